"""Speed against accuracy: what a fidelity costs, what it gives, and which one to take."""
