"""A page of the studio that drives."""

from contextlib import suppress

from playwright import sync_api

from chromium import until, wait_for


def drive(page: sync_api.Page) -> None:
    """Take over the flight where another page has it."""
    until(page, "document.body.dataset.ready && skylimbStudio.line.open")

    def drives() -> bool:
        take = page.get_by_role("button", name="Take over")
        with suppress(sync_api.TimeoutError):  # the seat was free just then, and the button went away
            if take.is_visible():
                take.click(timeout=1000)
        return page.evaluate("skylimbStudio.shell.seats.drives")

    wait_for(drives)
