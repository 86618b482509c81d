//! The controllers of the speed, and the planning of speeds.

pub(crate) mod controllers;
pub(crate) mod planning;
pub(crate) mod tracker;
