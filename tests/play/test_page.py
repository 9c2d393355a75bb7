"""The page in a real browser: dragged, played, by keyboard, saved and loaded."""

import json

import pytest

BALL = '#workspace [data-index="0"][tabindex]'
FIRST = 120_000  # [ms] until the first answer, which may compile


@pytest.fixture
def page(browser, server):
    """Open the page, and wait for its first answer; no script may fail."""
    failures = []
    context = browser.new_context(
        viewport={"width": 1280, "height": 800}, reduced_motion="reduce", accept_downloads=True
    )
    made = context.new_page()
    made.on("pageerror", lambda error: failures.append(str(error)))
    made.on("console", lambda m: failures.append(m.text) if m.type == "error" else None)
    made.goto(server.address)
    made.wait_for_selector(".result.caught", timeout=FIRST)
    yield made
    context.close()
    assert failures == []


def result(page):
    """Return the text of the first plan."""
    return page.text_content(".result")


def changes(page, before, what=".result"):
    """Wait until a text differs from an earlier one."""
    page.wait_for_function(
        "([what, before]) => document.querySelector(what).textContent !== before",
        arg=[what, before],
    )
    return page.text_content(what)


def drag(page, selector, dx, dy):
    """Drag something by an offset [pixels]."""
    box = page.locator(selector).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx / 2, y + dy / 2)
    page.mouse.move(x + dx, y + dy)
    page.mouse.up()


def test_a_dragged_target_is_answered_and_an_impossible_hand_is_explained(page):
    before = result(page)
    drag(page, BALL, 60, 20)
    assert changes(page, before) != before
    drag(page, '#workspace [data-index="-1"]', 60, 90)
    page.wait_for_selector("#problem:not([hidden])")
    assert "arm.hand" in page.text_content("#problem") and "out of reach" in page.text_content(
        "#problem"
    )
    drag(page, '#workspace [data-index="-1"]', -60, -90)
    page.wait_for_selector("#problem[hidden]", state="attached")


def test_arrows_and_handles_set_velocity_and_angle(page):
    page.click('#bodies button:has-text("bar")')
    angle, velocity = (
        page.locator(f'#fields label:has-text("{name}") input') for name in ("angle", "velocity x")
    )
    before = angle.input_value(), velocity.input_value()
    drag(page, '#workspace [data-act="turn"] .turn', 5, -40)
    drag(page, '#workspace [data-act="speed"][data-index="2"]', 50, 0)
    assert angle.input_value() != before[0] and float(velocity.input_value()) > float(before[1])


def test_the_film_is_moved_and_played(page):
    hand = page.locator('#workspace [data-index="-1"]')
    place = hand.get_attribute("transform")
    page.focus("#time")
    for _ in range(3):
        page.keyboard.press("PageUp")
    assert changes(page, "0.00 s", "#now") and hand.get_attribute("transform") != place
    now = page.text_content("#now")
    page.click("#play")
    changes(page, now, "#now")
    page.click("#play")
    assert "Play" in page.text_content("#play")


def test_it_works_by_keyboard(page):
    before = result(page)
    label = page.locator(BALL).get_attribute("aria-label")
    page.focus(BALL)
    for key in ("ArrowDown", "ArrowRight", "Shift+ArrowDown", "Shift+ArrowRight"):
        page.keyboard.press(key)
    assert page.locator(BALL).get_attribute("aria-label") != label
    changes(page, before)
    count = page.locator("#bodies button").count()
    page.focus('#workspace [data-index="1"][tabindex]')
    page.keyboard.press("Delete")
    page.wait_for_function(
        "(count) => document.querySelectorAll('#bodies button').length === count - 1", arg=count
    )


def shown(page):
    """Return the names of the bodies, and how the first one is read out."""
    return page.text_content("#bodies"), page.locator(BALL).get_attribute("aria-label")


def test_changes_are_undone_and_done_again(page):
    states = [shown(page)]
    page.focus('#workspace [data-index="1"][tabindex]')
    page.keyboard.press("Delete")
    changes(page, states[0][0], "#bodies")
    states.append(shown(page))
    drag(page, BALL, 40, 10)
    page.wait_for_timeout(200)
    states.append(shown(page))
    page.select_option("#family", "gate")
    changes(page, states[2][0], "#bodies")
    assert len({*states, shown(page)}) == 4
    for state in reversed(states):
        page.keyboard.press("Control+z")
        page.wait_for_timeout(200)
        assert shown(page) == state
    assert page.is_disabled("#undo")
    page.keyboard.press("Control+Shift+z")
    page.click("#redo")
    page.wait_for_timeout(200)
    assert shown(page) == states[2]
    page.click("#add-disc")
    assert page.is_disabled("#redo")


def test_no_letter_of_an_earlier_situation_stays(page):
    page.click("#explain")
    page.wait_for_selector("#letters li.found", timeout=60_000)
    drag(page, BALL, 30, 10)
    page.wait_for_selector("#letters:not(:has(.found))", state="attached")
    assert page.locator("#letters [aria-current]").count() == 0
    assert page.text_content("#reasons") == ""


def test_planners_are_compared_and_strata_explained(page):
    page.select_option("#planner-1", "straight")
    page.wait_for_selector(".plan.other .result.missed, .plan.other .result.caught")
    assert page.is_visible("#hands-1")
    page.click("#explain")
    page.wait_for_selector("#letters li.found", timeout=60_000)
    assert page.text_content("#letters li.found b") in "LWQU" and page.text_content("#reasons")


def test_situations_are_drawn_saved_loaded_and_shared(page, tmp_path):
    page.select_option("#family", "gate")
    page.fill("#index", "7")
    page.press("#index", "Enter")
    with page.expect_download() as saved:
        page.wait_for_timeout(500)
        page.click("#save")
    file = tmp_path / "saved.json"
    saved.value.save_as(file)
    situation = json.loads(file.read_text("utf-8"))
    assert situation["name"] == "gate-0000007" and situation["format"] == "gcm-learn/situation@1"
    situation["bodies"][0]["name"] = "apple"
    file.write_text(json.dumps(situation), "utf-8")
    page.set_input_files("#file", file)
    page.wait_for_selector('#bodies button:has-text("apple")')
    page.click("#share")
    address = page.url
    assert "#situation=" in address
    page.goto("about:blank")
    page.goto(address)
    page.wait_for_selector('#bodies button:has-text("apple")')


def test_it_fits_a_phone(page):
    page.set_viewport_size({"width": 400, "height": 800})
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    view = page.locator("#workspace .view").bounding_box()
    assert view["width"] > 300
    assert page.locator(".time").bounding_box()["y"] < 800, "the slider is in view"
