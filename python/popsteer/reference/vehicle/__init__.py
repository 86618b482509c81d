"""The vehicle: pose and speed, and where it will be."""
