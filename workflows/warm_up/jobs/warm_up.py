from workflows.execution.job import job
from workflows.warm_up.kernels import compile_kernels

with job(snakemake):
    compile_kernels(snakemake.output.stamp)
