"""Ctrl-C as a listener."""

from __future__ import annotations

import threading

from igl_spheremap.apps.cli.interrupt import Interrupt


def test_interrupts_can_be_listened_to_in_any_thread():
    errors = []

    def enter() -> None:
        try:
            with Interrupt():
                pass
        except ValueError as error:
            errors.append(error)

    thread = threading.Thread(target=enter)
    thread.start()
    thread.join()
    assert errors == []
