from workflows.execution.job import job
from workflows.large_strain.claims import write_claims
from workflows.large_strain.figures import write_fig8

with job(snakemake):
    data, out = snakemake.input.data, snakemake.output
    write_fig8(data, out.fig8, out.fig8_data)
    write_claims(data, table=out.table, markdown=out.markdown, page=out.page)
