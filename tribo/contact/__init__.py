"""Normal contact of rough, elastic, perfectly plastic bodies."""

from tribo.contact.elasticity import ElasticHalfSpace, ElasticKernel, elastic_influence
from tribo.contact.solver import ContactCriterion, ContactSolution, solve_contact

__all__ = [
    "ContactCriterion",
    "ContactSolution",
    "ElasticHalfSpace",
    "ElasticKernel",
    "elastic_influence",
    "solve_contact",
]
