from workflows.job import job
from workflows.warm_up import compile_kernels

with job(snakemake):
    compile_kernels(snakemake.output.stamp)
