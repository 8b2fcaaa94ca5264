from workflows.execution.job import job
from workflows.section_5_1 import claims, figures

with job(snakemake):
    data, out, params = snakemake.input, snakemake.output, snakemake.params
    levels = {"radius": params.radius, "converged": params.converged}
    figures.write_fig4(data.grids, params.drawn, out.fig4, out.fig4_data)
    figures.write_fig5(data.T3, **levels, picture=out.fig5, data=out.fig5_data)
    figures.write_fig6(
        data.T3, data.grids, params.swept, **levels, picture=out.fig6, data=out.fig6_data
    )
    figures.write_fig7(dict(data), **levels, picture=out.fig7, data=out.fig7_data)
    claims.write_claims(
        dict(data),
        data.scene,
        **levels,
        swept=params.swept,
        table=out.table,
        markdown=out.markdown,
        page=out.page,
    )
