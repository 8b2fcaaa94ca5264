from workflows.execution.job import job
from workflows.section_5_1 import claims, figures

with job(snakemake):
    data, out, params = snakemake.input, snakemake.output, snakemake.params
    series, levels = dict(data), {"radius": params.radius, "converged": params.converged}
    figures.write_fig4(data.grids, params.drawn, data.scene, params.radius, out.fig4, out.fig4_data)
    figures.write_fig5(series, **levels, picture=out.fig5, data=out.fig5_data)
    figures.write_fig6(
        series, data.grids, params.swept, **levels, picture=out.fig6, data=out.fig6_data
    )
    figures.write_fig7(series, **levels, picture=out.fig7, data=out.fig7_data)
    figures.write_error(series, **levels, picture=out.error, data=out.error_data)
    claims.write_claims(
        series,
        data.grids,
        data.scene,
        **levels,
        swept=params.swept,
        table=out.table,
        markdown=out.markdown,
        page=out.page,
    )
