"""All of a control step around a controller, by `Tracker`: estimate, predict, locate, limit."""
