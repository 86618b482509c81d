"""The lateral controllers, one a file, behind `LateralLaw`."""
