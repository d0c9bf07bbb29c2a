"""What a sphere is good for: locate, transfer, resample, texture."""
