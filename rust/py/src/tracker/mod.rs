//! What all lateral controllers have in common: their steps, what these take and return, their
//! state.

pub(crate) mod command;
pub(crate) mod commands;
pub(crate) mod controller;
pub(crate) mod monitor;
pub(crate) mod prediction;
pub(crate) mod state;
