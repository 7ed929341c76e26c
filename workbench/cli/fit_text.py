"""What `workbench fit` prints for people."""

from __future__ import annotations

from typing import Any

from workbench.cli.output import print_table

Content = dict[str, Any]
_LEVELS = (0.25, 0.5, 0.75, 1.0)


def strength(result: Content) -> None:
    """Formulas against tests, D.8, campaigns left out, Annex B, warnings."""
    fits = [content["fit"] for content in result["models"]]
    _head(result, f"{fits[0]['tests']} tests of {', '.join(fits[0]['campaigns'])}")
    for name, text in result["not_fitted"].items():
        print(f"not fitted: {name}: {text}")
    share = f"{100.0 * result['confidence']:g} %"
    print("Test over prediction:")
    print_table(
        [
            (
                fit["model"],
                _number(fit["parameters"]["bias"]["value"]),
                _span(fit["parameters"]["bias"]["profile"]),
                _span(fit["parameters"]["bias"]["bootstrap"]),
                _number(fit["sigma"]["value"]),
                _number(fit["tau"]["value"]),
                _number(fit["new_campaign_factor"]),
            )
            for fit in fits
        ],
        ("formula", "median", share, "bootstrap", "within", "between", "5 % of a new campaign"),
    )
    _trends(fits)
    _factors(result["models"])
    _validation(result)
    print("\nEN 1990 D.8 (all tests independent), kN for the stud in the middle of the tests:")
    names = ("b", "V_delta", "V_rt", "V_r", "k_n", "k_dn")
    print_table(
        [
            (
                fit["model"],
                *(_number(fit["d8"][name]) for name in names),
                _number(fit["d8"]["r_m"], 1e-3, 4),
                _number(fit["d8"]["r_k"], 1e-3, 4),
                *_design(fit["d8"]),
            )
            for fit in fits
        ],
        ("formula", *names, "g_rt(X_m)", "r_k", "r_d", "gamma_M*"),
    )
    print("  g_rt(X_m) is the formula itself at mean values, r_k and r_d contain its correction b;")
    print("  gamma_M* is the nominal value of the code over r_d.")
    _left_out(fits)
    _series(result["series"])
    _warnings([fit["warnings"] for fit in fits])


def load_slip(result: Content) -> None:
    """Parameters of the laws over the curves, unseen curves, warnings."""
    fits = [content["fit"] for content in result["laws"]]
    _head(result, f"{fits[0]['curves']} curves of {', '.join(fits[0]['campaigns'])}")
    units = {"rate": (1e-3, "1/mm"), "yield_slip": (1e3, "mm"), "peak_slip": (1e3, "mm")}
    rows = []
    for fit in fits:
        for name, value in fit["population"].items():
            factor, unit = units.get(name, (1.0, ""))
            rows.append(
                (
                    fit["law"], f"{name} {unit}".strip(), _number(value["median"], factor),
                    _span(value["profile"], factor), _span(value["bootstrap"], factor),
                    _number(value["sigma"]["value"]), _number(value["tau"]["value"]),
                    _number(fit["median_rms"]),
                )
            )  # fmt: skip
    share = f"{100.0 * result['confidence']:g} %"
    header = ("law", "parameter", "median", share, "bootstrap", "within", "between", "misfit")
    print_table(rows, header)
    if fits[0]["median_rms_of_published_ollgaard"] is not None:
        rms, bias = (
            _number(fits[0][f"median_{name}_of_published_ollgaard"]) for name in ("rms", "bias")
        )
        print(f"Ollgaard's published law on these curves: misfit {rms}, bias {bias} of the load.")
    judged = [(c["fit"]["law"], c["judgement"]) for c in result["laws"] if c["judgement"]]
    if judged:
        print("\nUnseen curves:")
        print_table(
            [
                (
                    law, str(j["curves"]), _number(j["median_rms"]), _number(j["coverage"]),
                    _number((j["stiffness"] or {}).get("test_over_prediction")),
                    _span((j["stiffness"] or {}).get("interval")),
                )
                for law, j in judged
            ],
            ("law", "curves", "misfit", "inside the band", "stiffness, test over law", share),
        )  # fmt: skip
    for fit in fits[:1]:
        for text in fit["skipped"]:
            print(f"left out: {text}")
    _warnings([fit["warnings"] for fit in fits])


def residual(result: Content) -> None:
    """The grade first, then what is left, the choice of the relation, warnings."""
    tested = [content["fit"]["tests"] for content in result["quantities"]]
    _head(result, f"{max(tested)} tests after pre-damage")
    print(f"GRADE: {result['grade']}\n")
    rows = []
    for content in result["quantities"]:
        fit, curve = content["fit"], content["curve"]
        cells = []
        for level in _LEVELS:
            at = min(range(len(curve["level"])), key=lambda i: abs(curve["level"][i] - level))
            text = _number(curve["left"][at])
            if curve["low"] is not None:
                text += f" ({_number(curve['low'][at], 1.0, 2)} to "
                text += f"{_number(curve['high'][at], 1.0, 2)})"
            cells.append(text)
        rows.append((fit["quantity"], f"{fit['predamage']}, {fit['measure']}", *cells))
    print_table(rows, ("left of", "after", *(f"level {level:g}" for level in _LEVELS)))
    print("  In parentheses: a mechanical prediction over its unknown parameters, or 90 % of new")
    print("  tests (of three campaigns or more). Level 1: what an undamaged stud bears.")
    for content in result["quantities"]:
        fit = content["fit"]
        if content["tests"]:
            print(f"\n{fit['quantity']}: {fit['formula']} ({fit['tests']} tests, {fit['grade']})")
            parameters = [
                (f"  {name}", _number(value), _span(fit["profile"][name]),
                 _span(fit["bootstrap"].get(name)))
                for name, value in fit["parameters"].items()
            ]  # fmt: skip
            print_table(parameters)
            scores = ", ".join(f"{each['name']} {each['rms']:.3f}" for each in fit["scores"]
                               if each["rms"] is not None)  # fmt: skip
            by = fit["scores"][0]["by"]
            print(f"  root mean square of what is left out, by {by}: {scores}")
        if content["judgement"]:
            judgement = content["judgement"]
            ratio = _number(judgement["test_over_prediction"])
            print(f"  unseen: {judgement['tests']} tests, test over prediction {ratio} "
                  f"({_span(judgement['interval'])}), worst {judgement['worst']} "
                  f"{_number(judgement['least_test_over_prediction'])}")  # fmt: skip
    _warnings([content["fit"]["warnings"] for content in result["quantities"]])


def _design(d8: Content) -> tuple[str, str]:
    """Design value and partial factor, where EN 1990 has a fractile factor."""
    from workbench.studs.strength import LEAST_FOR_DESIGN

    if d8["count"] < LEAST_FOR_DESIGN:
        return "-", "-"
    return _number(d8["r_d"], 1e-3, 4), _number(d8["gamma_m_star"])


def _head(result: Content, what: str) -> None:
    tables = " and ".join("shipped tables" if t == "shipped" else t for t in result["tables"])
    print(f"{what} ({tables})")
    for text in result["rows_left_out"]:
        print(f"left out: {text}")
    print()


def _trends(fits: list[Content]) -> None:
    rows = [
        (fit["model"], name, _number(value["value"]), _span(value["profile"]))
        for fit in fits
        for name, value in fit["parameters"].items()
        if name != "bias"
    ]
    if rows:
        print("\nExponents that the formulas miss:")
        print_table(rows, ("formula", "variable", "exponent", "interval"))


def _factors(models: list[Content]) -> None:
    rows = [
        (content["fit"]["model"], name, _number(value), _span(content["factors"]["profile"][name]))
        for content in models
        if content["factors"]
        for name, value in content["factors"]["factors"].items()
    ]
    if rows:
        print("\nFitted factors of the formulas:")
        print_table(rows, ("formula", "term", "factor", "interval"))


def _validation(result: Content) -> None:
    rows = []
    for content in result["models"]:
        for kind, name in (("as it is", "judgement"), ("as fitted", "corrected")):
            judged = content[name]
            if judged:
                rows.append(
                    (
                        content["fit"]["model"], kind, str(judged["tests"]),
                        _number(judged["test_over_prediction"]), _span(judged["interval"]),
                        _number(judged["least_test_over_prediction"]), judged["worst"],
                    )
                )  # fmt: skip
    if rows:
        print(f"\nUnseen tests of {', '.join(result['validate'])}, test over prediction:")
        print_table(
            rows, ("formula", "prediction", "tests", "median", "interval", "least", "which")
        )


def _left_out(fits: list[Content]) -> None:
    rows = [
        (
            fit["model"], each["campaign"], str(each["count"]), f"{100.0 * each['bias']:+.1f} %",
            f"{100.0 * each['rms']:.1f} %",
            "too few campaigns" if each["covered"] is None else f"{100.0 * each['covered']:.0f} %",
        )
        for fit in fits
        for each in fit["left_out"]
    ]  # fmt: skip
    if rows:
        print("\nEach campaign predicted from the others (logarithm of test over prediction):")
        print_table(rows, ("formula", "campaign", "tests", "bias", "rms", "inside the 90 % band"))


def _series(series: list[Content]) -> None:
    evaluated = [each for each in series if each["result"]]
    print("\nEN 1994-1-1 Annex B.2, nominally equal tests:")
    if not evaluated:
        largest = max(each["tests"] for each in series)
        print(f"  none of {len(series)} groups can be evaluated (the largest has {largest}): "
              f"{series[0]['refusal']}")  # fmt: skip
        return
    rows = []
    for each in evaluated:
        found = each["result"]
        word = {True: "ductile", False: "brittle", None: "not known"}[found["ductile"]]
        rows.append(
            (
                each["name"], str(each["tests"]), _number(found["P_Rk"], 1e-3, 4),
                _number(found["P_Rd"], 1e-3, 4), _number(found["slip_capacity"], 1e3), word,
                found["note"],
            )
        )  # fmt: skip
    print_table(rows, ("series", "tests", "P_Rk kN", "P_Rd kN", "delta_uk mm", "class", "note"))


def _warnings(groups: list[list[str]]) -> None:
    texts = dict.fromkeys(text for group in groups for text in group)
    if texts:
        print()
    for text in texts:
        print(f"warning: {text}")


def _number(value: float | None, factor: float = 1.0, digits: int = 3) -> str:
    return "-" if value is None else f"{factor * value:.{digits}g}"


def _span(interval: Content | None, factor: float = 1.0) -> str:
    if interval is None:
        return "too few campaigns"
    low, high = (
        "open" if interval[side] is None else f"{factor * interval[side]:.3g}"
        for side in ("low", "high")
    )
    return f"{low} to {high}"
