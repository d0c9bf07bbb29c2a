"""The witness: certificates and distortion. It imports no solver."""
