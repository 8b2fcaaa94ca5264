"""The Snakemake workflow, by subject: rules beside the code that they call.

The paper, measurements of speed, the stability study, and parameter studies in batches.
"""
