//! Behaviour of models against closed forms.

mod closest;
mod damage;
mod shapes;
