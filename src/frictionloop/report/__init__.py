"""The paper's figures and claims on one page."""
