"""What the Snakemake rules call: the paper's figures and the measurements of speed."""
