from workflows.execution.job import job
from workflows.large_strain.claims import write_claims
from workflows.large_strain.datasets import write_large_strain, write_steps
from workflows.large_strain.figures import write_fig8
from workflows.large_strain.laws_figure import write_laws

with job(snakemake):
    data, out = snakemake.input, snakemake.output
    write_large_strain(data.study, data.scene, out.curves)
    write_steps(data.as_printed, data.scene, out.steps)
    write_fig8(out.curves, out.steps, out.fig8, out.fig8_data)
    write_laws(out.curves, out.laws, out.laws_data)
    write_claims(out.curves, out.steps, table=out.table, markdown=out.markdown, page=out.page)
