//! What is written as STEP comes back.
