"""The paper's figures and claims, rebuilt: one self-contained page, SVG figures, and the claims as JSON."""
