"""What is done with maps: location, transfer, resampling, textures, harmonics, registration."""
