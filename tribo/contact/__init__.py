"""Normal contact of rough, elastic, perfectly plastic bodies."""

from tribo.contact.elasticity import ElasticHalfSpace as ElasticHalfSpace
from tribo.contact.elasticity import ElasticKernel as ElasticKernel
from tribo.contact.solver import ContactSolution as ContactSolution
from tribo.contact.solver import solve_contact as solve_contact
