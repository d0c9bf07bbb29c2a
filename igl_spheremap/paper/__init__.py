"""Lai, Wen, Yin, Gu, Lui 2014: Algorithm 1, the star map and Algorithm 2, to be read beside the paper."""
