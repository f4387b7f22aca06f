"""Flash temperature, heat partition, and the temperature over the contact."""
