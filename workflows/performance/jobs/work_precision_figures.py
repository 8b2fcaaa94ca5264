from workflows.execution.job import job
from workflows.performance import defaults, figures

with job(snakemake):
    data, out = snakemake.input.data, snakemake.output
    figures.draw_work_precision(data, out.errors)
    figures.draw_paths(data, out.paths)
    figures.draw_grading(data, out.grading)
    figures.draw_solvers(data, out.solvers)
    pictures = {
        "Error against CPU time": out.errors,
        "Growing cracks against CPU time": out.paths,
        "Grading and domain radius": out.grading,
        "Solvers": out.solvers,
    }
    defaults.write_defaults(data, pictures, out.page)
