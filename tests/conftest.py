import numpy as np
import pytest

collect_ignore_glob = ["**/references/*"]  # scripts that made the references, not tests


@pytest.fixture(autouse=True)
def _floating_point_faults_are_errors():
    with np.errstate(all="raise", under="ignore"):
        yield
