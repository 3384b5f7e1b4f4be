"""Queues on topics, offers from outside, services."""

import pytest

from graph.base.errors import RunError
from graph.sim.messages.bus import MemorySink, MessageBus


def taken(subscription):
    found = []
    while (message := subscription.take()) is not None:
        found.append(message.message)
    return found


def test_a_subscription_holds_what_came_oldest_first():
    bus = MessageBus()
    heard = bus.listen("/a", "t")
    bus.publish("/a", "t", 1, 0)
    bus.publish("/b", "t", 2, 0)
    bus.publish("/a", "t", 3, 0)
    assert len(heard) == 2
    assert taken(heard) == [1, 3]


def test_a_full_queue_drops_the_oldest_and_counts_it():
    bus = MessageBus()
    heard, everything = bus.listen("/a", "t", depth=2), bus.listen("/a", "t", depth=0)
    for number in range(5):
        bus.publish("/a", "t", number, 0)
    assert taken(heard) == [3, 4]
    assert heard.dropped == 3
    assert taken(everything) == [0, 1, 2, 3, 4]


def test_a_subscription_gets_what_came_earlier_in_the_same_update_and_nothing_older():
    bus = MessageBus()
    bus.publish("/a", "t", "old", 0)
    bus.begin_update()
    bus.publish("/a", "t", "new", 0)
    assert taken(bus.listen("/a", "t")) == ["new"]


def test_an_offer_is_made_only_with_a_listener():
    bus, made = MessageBus(), []
    sink = MemorySink()
    bus.subscribe(sink)

    def load():
        made.append(1)
        return "x"

    bus.offer("/a", "t", 5, load)
    assert made == []
    assert sink["/a"] == []
    heard = bus.listen("/a", "t")
    assert taken(heard) == ["x"]
    assert [one.stamp_ns for one in sink["/a"]] == [5]
    bus.offer("/a", "t", 6, load)
    assert len(made) == 2
    assert len(heard) == 1
    bus.begin_update()
    bus.unlisten(heard)
    bus.offer("/a", "t", 7, load)
    bus.begin_update()
    assert taken(bus.listen("/a", "t")) == []
    assert len(made) == 2


def test_a_subscription_makes_a_topic_wanted_until_it_ends():
    bus = MessageBus()
    assert not bus.has_subscribers("/a")
    heard = bus.listen("a", "t")
    assert bus.has_subscribers("/a")
    assert not bus.has_subscribers("/b")
    assert bus.is_listened_to("a")
    bus.unlisten(heard)
    bus.unlisten(heard)
    assert not bus.has_subscribers("/a")


def test_a_topic_has_one_type_in_any_order_of_clients():
    bus = MessageBus()
    bus.listen("/a", "t", owner="/G/listen")
    with pytest.raises(RunError, match="topic /a: /G/send sends u, but /G/listen expects t; rename"):
        bus.advertise("/a", "u", "/G/send")
    bus.advertise("/b", "u", "/G/send")
    with pytest.raises(RunError, match="topic /b: /G/send sends u, but /G/listen expects t; rename"):
        bus.listen("/b", "t", owner="/G/listen")


def test_a_server_hands_out_requests_and_answers_them_in_order():
    services = MessageBus().services
    server = services.serve("/add", "s", "/G/server")
    first, second = services.call("/add", "s", 1), services.call("/add", "s", 2)
    assert server.take() == 1
    assert server.take() == 2
    assert server.take() is None
    assert server.answer("one")
    assert first.response == "one"
    assert second.response is None
    assert server.answer("two")
    assert second.response == "two"
    assert not server.answer("three")


def test_a_service_has_one_server_of_one_type():
    services = MessageBus().services
    server = services.serve("/add", "s", "/G/server")
    with pytest.raises(RunError, match="service /add has a server already: /G/server"):
        services.serve("/add", "s")
    with pytest.raises(RunError, match="/G/client calls u, but /G/server serves s"):
        services.call("/add", "u", 1, "/G/client")
    call = services.call("/add", "s", 1)
    services.close(server)
    services.close(server)
    assert call.lost
    assert services.call("/add", "s", 1) is None
    assert services.server(server.handle) is None
