"""The paper's sections: datasets, figures and claims."""
