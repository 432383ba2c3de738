//! Rigid registration of clouds to shapes and to each other by quadratic models of the squared distance.
