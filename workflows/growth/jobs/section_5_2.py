from workflows.execution.job import job
from workflows.growth.edge_figures import write_fig9, write_fig10, write_scatter_edge

with job(snakemake):
    growth, scene, out = snakemake.input.growth, snakemake.input.scene, snakemake.output
    write_fig9(growth, out.fig9, out.fig9_data)
    write_fig10(growth, scene, snakemake.params.variants, out.fig10, out.fig10_data)
    write_scatter_edge(snakemake.input.scatter, out.scattered, out.scattered_data)
