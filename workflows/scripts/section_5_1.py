from workflows.job import job
from workflows.paper import claims_5_1, figures_5_1

with job(snakemake):
    data, out, params = snakemake.input, snakemake.output, snakemake.params
    levels = {"radius": params.radius, "converged": params.converged}
    figures_5_1.write_fig4(data.grids, params.drawn, out.fig4, out.fig4_data)
    figures_5_1.write_fig5(data.T3, **levels, picture=out.fig5, data=out.fig5_data)
    figures_5_1.write_fig6(
        data.T3, data.grids, params.swept, **levels, picture=out.fig6, data=out.fig6_data
    )
    figures_5_1.write_fig7(dict(data), **levels, picture=out.fig7, data=out.fig7_data)
    claims_5_1.write_claims(
        dict(data),
        data.scene,
        **levels,
        swept=params.swept,
        table=out.table,
        markdown=out.markdown,
        page=out.page,
    )
