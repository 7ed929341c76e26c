"""Uncertain inputs, and the probability of exceedance that follows from them."""
