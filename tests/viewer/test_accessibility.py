"""axe-core finds nothing serious, whatever the page shows."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.viewer.pages import choose, select

AXE = (Path(__file__).parent / "axe" / "axe.min.js").read_text(encoding="utf-8")
SIZES = {"desktop": {"width": 1200, "height": 760}, "phone": {"width": 390, "height": 844, "phone": True}}


def findings(browser):
    """What is serious or critical: the rule and where."""
    browser.run(f"window.axe || (() => {{ {AXE} }})(); 0")
    found = browser.run(
        "axe.run().then(({violations, passes}) => [passes.length, violations"
        ".filter(({impact}) => impact === 'serious' || impact === 'critical')"
        ".map(({id, nodes}) => [id, nodes.map((node) => [node.html, node.failureSummary])])])"
    )
    assert found[0] > 20  # it has looked
    return found[1]


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_no_serious_finding(browser, everything, size, dark):
    browser.open(everything, dark=dark, **SIZES[size])
    assert findings(browser) == []
    select(browser, 2)
    choose(browser, "alignment", 1)
    choose(browser, "spheres", 1)
    choose(browser, "surface", 3)
    browser.run("list.open = notes.open = true")
    assert findings(browser) == []
    browser.run("votes.click()")
    browser.settle()
    assert findings(browser) == []


def test_what_is_wrong_is_found(browser, everything):
    browser.open(everything)
    browser.run("count.style.color = '#ddd'; document.querySelector('header').append(document.createElement('button'))")
    assert [name for name, _ in findings(browser)] == ["button-name", "color-contrast"]
