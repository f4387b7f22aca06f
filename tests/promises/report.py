"""Report of a campaign: number of promises kept."""

import numpy as np

ACCURACIES = (0.05, 0.02, 0.01)
PROMISED = {"draft": 0.08, "standard": 0.03, "fine": 0.01}


def report(rows_by_seed):
    """Print how many promises were kept, of what is known of each scene by its parts."""
    rows = [row for parts in rows_by_seed.values() for row in parts.values()]
    failed = {row["seed"] for row in rows if "failed" in row}
    done = [row for row in rows if "failed" not in row]
    true = [row for row in done if row["part"] == "truth"]
    print(f"{len(true)} true boundaries known; {len(failed)} scenes came to no result")
    _presets([row for row in done if row["part"] == "presets"])
    _accuracies([row for row in done if row["part"] == "accuracies"])


def _presets(rows):
    for name, bound in PROMISED.items() if rows else ():
        errors = np.array([row[name]["error"] for row in rows])
        warned = np.array([bool(row[name]["warnings"]) for row in rows])
        within = errors <= bound
        print(
            f"{name:10} {within.sum()} of {len(rows)} within {bound:.0%}; median "
            f"{np.median(errors):.2%}, 90 % below {np.quantile(errors, 0.9):.2%}, largest "
            f"{errors.max():.1%}; beyond it without a warning: {np.sum(~within & ~warned)}, within "
            f"it with one: {np.sum(within & warned)}; largest without one "
            f"{errors[~warned].max(initial=0):.2%}; with the heat of the past in the truth "
            f"{sum(row[name]['with_past'] <= bound for row in rows)} within"
        )


def _accuracies(rows):
    for accuracy in ACCURACIES if rows else ():
        results = [row[f"{accuracy:g}"] for row in rows]
        errors = np.array([result["error"] for result in results])
        foretold = np.array([result["foretold"] for result in results])
        missed = [
            f"scene {row['seed']} {result['error']:.2%} of {result['foretold']:.2%} foretold "
            f"({result['name']}; {', '.join(result['warnings']) or 'no warning'})"
            for row, result in zip(rows, results, strict=True)
            if result["error"] > max(accuracy, result["foretold"])
        ]
        print(
            f"{accuracy:.0%}: kept {np.sum(errors <= accuracy)} of {len(results)}; as foretold or "
            f"less where the finest was said to err by more: "
            f"{np.sum((errors > accuracy) & (errors <= foretold))}; foretold error "
            f"exceeds the true one in {np.mean(foretold >= errors):.1%}; median error "
            f"{np.median(errors):.2%}, largest {errors.max():.2%}; missed: "
            + (", ".join(missed) or "none")
        )
