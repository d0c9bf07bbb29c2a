"""What is measured of the package: ``python -m benchmarks --list`` lists it, ``python -m benchmarks NAME`` runs one."""
