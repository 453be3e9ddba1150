"""The report as JUnit XML, which continuous integration reads: one suite a file, one test a case.

A case of which nothing is expected counts as skipped there, which knows no other way to be neither passed nor failed.
"""

import re
from itertools import groupby
from xml.etree import ElementTree as ET

from stackdsl.outcome import UNCHECKED, Report, RunStatus, VariantResult
from stackdsl.report.outcome_text import unchecked_text
from stackdsl.report.worst_first import findings_of
from stackdsl.shown_text import visible

NO_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # what XML 1.0 cannot hold


def report_junit(report: Report) -> str:
    """The whole report; mistakes of files, and golden files that are nobody's, are errors of suites of their own."""
    root = ET.Element("testsuites", name="stackdsl", time=f"{report.wall_time:.3f}")
    for file, group in groupby(report.results, key=lambda result: result.file):
        results = list(group)
        suite = ET.SubElement(root, "testsuite", name=_clean(file))
        if unchecked := sum(result.unchecked for result in results):
            told = ET.SubElement(suite, "properties")
            ET.SubElement(told, "property", name=UNCHECKED, value=str(unchecked))
        for result in results:
            _case(suite, result)
    _errors(root, "mistakes", [(f"{each.span}", f"{each.code} {each.message}") for each in report.diagnostics])
    _errors(root, "golden files", [(visible(file), "obsolete: no variant has this name") for file in report.obsolete])
    for counted in [*root, root]:
        cases = list(counted.iter("testcase"))
        counted.set("tests", str(len(cases)))
        for kind, name in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
            counted.set(name, str(sum(case.find(kind) is not None for case in cases)))
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, result: VariantResult) -> None:
    time = result.cost.wall_time if result.cost is not None and not result.remembered else 0.0
    named = {"name": _clean(result.name), "classname": _clean(result.scenario), "file": _clean(result.file)}
    case = ET.SubElement(suite, "testcase", {**named, "time": f"{time:.3f}"})
    told = {
        "system": result.system,
        "verdict": result.verdict,
        "conclusion": result.conclusion,
        **dict(result.parameters),
    }
    properties = ET.SubElement(case, "properties")
    for name, value in told.items():
        ET.SubElement(properties, "property", name=_clean(name), value=_clean(value))
    for odd in result.warnings:
        ET.SubElement(properties, "property", name="warning", value=_clean(str(odd)))
    if result.status is RunStatus.SKIPPED:
        ET.SubElement(case, "skipped", message=_clean(result.message))
    found = list(findings_of(result))
    if found:
        kind = "failure" if result.status is RunStatus.DONE else "error"
        text = "\n".join(f"{each.file}:{each.line}:{each.column}: {each.text}" for each in found)
        ET.SubElement(case, kind, message=_clean(found[0].text)).text = _clean(text)
    elif result.unchecked:
        ET.SubElement(case, "skipped", message=_clean(f"{UNCHECKED}: {unchecked_text(result)}"))


def _errors(root: ET.Element, title: str, found: list[tuple[str, str]]) -> None:
    if found:
        suite = ET.SubElement(root, "testsuite", name=title)
        for place, text in found:
            case = ET.SubElement(suite, "testcase", name=_clean(place), classname=title)
            ET.SubElement(case, "error", message=_clean(text))


def _clean(text: str) -> str:
    return NO_XML.sub("\ufffd", text)
