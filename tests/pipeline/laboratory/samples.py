"""Exports of machines, each in the layout of the machine's files and with numbers of its own.

All but those of stages and of results have one run: the load rises by stages of 40 s, and friction
goes from 0.1 to 0.3 in the middle of the fourth.
"""

import io

import numpy as np

STAGES = 100.0 * np.repeat([1, 2, 3, 4], 40)  # N
TIME = np.arange(len(STAGES)) * 1.0  # s
IS_SEVERE = TIME >= 140.0
SPEED = 0.5  # m/s
TRACK = 20.0  # mm
TURNS = SPEED / (2 * np.pi * TRACK / 1e3) * 60  # rpm


def noise(seed):
    return np.random.default_rng(seed).normal(size=len(TIME))


FRICTION = np.where(IS_SEVERE, 0.3, 0.1) + 0.002 * noise(1)
LOAD = STAGES + 0.5 * noise(2)
OIL = 80.0 + 0.05 * noise(3)  # °C


def lines(separator, *columns, form="{:.5g}"):
    """Rows of a table as text, from its columns."""
    texts = (
        [form.format(x) if np.isreal(x) else x for x in row] for row in zip(*columns, strict=True)
    )
    return [separator.join(row) for row in texts]


def text(*parts, end="\n"):
    """Lines and lists of lines joined to a text."""
    flat = (line for part in parts for line in ([part] if isinstance(part, str) else part))
    return end.join([*flat, ""])


def rtec():
    stage = np.repeat([1, 2, 3, 4], 40)
    return text(
        "Recipe,Load steps,,,,,,,",
        "",
        "Timestamp,RecipeStep,DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),Rotary.Velocity (rpm),XYZ.Z (mm),"
        "DAQ.Temp1 (C),",
        [
            f"{one},"
            for one in lines(
                ",",
                TIME % 40,
                stage,
                LOAD,
                FRICTION * LOAD,
                FRICTION,
                0 * TIME + TURNS,
                2.5 + 0 * TIME,
                OIL,
            )
        ],
        "TotalTime,159.0",
        "3/14/2026 9:26:53 AM",
    )


def umt():
    grams = 1000 / 9.80665
    parts = ["CETR UMT data,,,,,", "Run # 7,,,,,"]
    for number in range(4):
        here = slice(40 * number, 40 * number + 40)
        parts += [
            f"Step {number + 1},,,,,", "Step Type Code,4,,,,", "T,Fx,Fz,Ff,COF,Z",
            "sec,grams,grams,grams,,mm",
        ]  # fmt: skip
        parts += lines(
            ",", TIME[here] - TIME[here][0], grams * FRICTION[here] * LOAD[here],
            -grams * LOAD[here], grams * FRICTION[here] * LOAD[here], FRICTION[here],
            0 * TIME[here] + 11.5,
        )  # fmt: skip
    return text(parts, end="\r\n")


def compend():
    heads = ["Test Time", "This Step", "Load (N)", "Friction (N)", "Friction Coefficient",
             "Frequency (Hz)", "Stroke (mm)", "Oil Temp (°C)", "Total Cycles"]  # fmt: skip
    rows = lines(
        "\t", TIME, TIME % 40, LOAD, FRICTION * LOAD, FRICTION, 0 * TIME + 25, 0 * TIME + 10,
        OIL, 25 * TIME,
    )  # fmt: skip
    rows[80:80] = ["Fast data in demo_f1.tsv"]
    return text(
        "Test started at 09:26:53 on 14/03/2026",
        *(f"\t{row}\t" if "\t" in row else row for row in ["\t".join(heads), *rows]),
        "Test ended at 09:29:33",
    )


def trb3():
    heads = ["Time [s]", "Distance [m]", "Sequence ID", "Cycle ID", "Max linear speed [m/s]",
             "Nominal load [N]", "Normal force [N]", "Friction force [N]", "µ"]  # fmt: skip
    rows = lines(
        "\t", TIME, SPEED * TIME, 0 * TIME + 1, TIME, 0 * TIME + SPEED, STAGES, LOAD,
        FRICTION * LOAD, FRICTION,
    )  # fmt: skip
    return text("TriboX 4.5", "Tribometer\tTRB3", "Radius\t20 [mm]", "", "\t".join(heads), rows)


def sine():
    """Export of the same machine with a reciprocating sample."""
    return trb3().replace("Radius\t20 [mm]", "Linear mode\nHalf amplitude\t5 [mm]")


def t11():
    heads = ["Time [s]", "Friction force [N]", "Displacement [um]", "Temperature1 [C]",
             "Temperature2 [C]", "Rotational speed [rpm]", "Number of revolutions"]  # fmt: skip
    rows = lines(
        ";", TIME, 50 * FRICTION, 0 * TIME + 3, OIL, 0 * TIME + 22, 0 * TIME + TURNS, TIME,
    )  # fmt: skip
    return text("T-11 tester", ";".join(heads), rows).replace(".", ",")


def mtm():
    parts = ["MTM2 test data file", "Profile\tdemo", ""]
    for number in range(4):
        here = slice(40 * number, 40 * number + 40)
        parts += [
            f"Step {number + 1}", "Step Type\tTimed",
            "Step Time (s)\tRolling Speed (mm/s)\tSRR (%)\tBall Load (N)\tTraction Force (N)\t"
            "Traction Coeff (-)\tLubricant Temp (°C)",
        ]  # fmt: skip
        parts += lines(
            "\t", TIME[here] - TIME[here][0], 0 * TIME[here] + 1000, 0 * TIME[here] + 50,
            LOAD[here] / 10, FRICTION[here] * LOAD[here] / 10, FRICTION[here], OIL[here],
        )  # fmt: skip
    return text(parts, end="\r\n")


def srv():
    """Content of a workbook with a cover sheet, and units below the headings."""
    import openpyxl

    book = openpyxl.Workbook()
    book.active.title = "Cover"
    book.active.append(["Optimol SRV"])
    sheet = book.create_sheet("Results")
    for row in (
        ["Optimol SRV 5", None, "ASTM D7421"],
        [],
        ["Oil", "O.K. load", "Seizure load", "Frequency", "Stroke", "Temperature"],
        [None, "N", "N", "Hz", "mm", "°C"],
        ["A", 700, 800, 50, 1, 120],
        ["B", ">2000", None, 50, 1, 120],
        ["C", 500, None, 50, 1, 120],
    ):
        sheet.append(row)
    content = io.BytesIO()
    book.save(content)
    return content.getvalue()
