"""The sensor scheduler: in the render phase of each update it renders exactly the products that are due."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim.timing.clocks import PhysicsClock, Reading

from .products import ProductList, RenderProduct
from .schedule import NEVER, EveryUpdate, Tick, TickSchedule
from .sensor import SensorFrame

if TYPE_CHECKING:
    from .view import WorldView


class SensorScheduler(ProductList):
    """Renders products by ticks on the physics clock, in the order of their creation.

    With multi-tick rendering off there is no separate sensor clock: `loop_time` (the run loop's time since the App was
    made, which continues while the timeline is paused) replaces the external time, and every sensor renders in every
    update while playing, except an accumulating one, which gives its scan in the update that completes it.
    """

    def __init__(
        self, clock: PhysicsClock, capture: Callable[[], Any] | None, loop_time: Callable[[], Fraction]
    ) -> None:
        super().__init__()
        self.new_frames: list[RenderProduct] = []
        """The products that delivered a frame in this update, in the order of their creation."""
        self.polled: dict[str, Any] | None = None
        """Sensors without a product, which are measured when they are read, by their prims; None until one is read
        (`sensors.polled`).
        """
        self.scene: WorldView
        """What the sensors measure."""
        self.capture_state = capture
        """Takes an immutable snapshot of all poses; None if nothing moves."""
        self.multi_tick = True
        self.capture_at_ticks = True
        self.autotrigger_idle = False
        """Whether sensors of tick rate 0 also render in updates in which the external time does not advance."""
        self.stepped = False
        """Whether the orchestrator runs this update; it marks the frames, for writers that take no others."""
        self.capture_held = False
        """Whether every product also renders the world as it stands, unless it is due in the update anyway."""
        self.frames_later = False
        """Whether a frame is delivered by `deliver_pending` instead of in the update that renders it."""
        self.next_capture = NEVER
        """The step count after which `capture` must be called."""
        self._clock = clock
        self._loop_time = loop_time
        self._began_at: Reading | Fraction | None = None  # or, on the loop's time, how long before it
        self._next_due = NEVER
        self._rate: Fraction | None = None
        self._rendered_step = 0
        self._rendered_version = clock.version
        self._captures: list[tuple[int, int, RenderProduct]] = []
        self._pending: list[tuple[Fraction, RenderProduct, SensorFrame, bool]] = []  # from when, ..., stepped
        self._rendered: list[RenderProduct] = []
        self._held = True  # without multi-tick rendering: nothing was rendered in the update before

    # -- products ----------------------------------------------------------------------------------------------------

    def add(self, product: RenderProduct) -> RenderProduct:
        """Adds a product. Raises UserError if its path is taken."""
        super().add(product)
        moment = self.moment
        product.restart(moment if product.created_at is None else max(moment, product.created_at))
        product.on_enabled = self._enabled_changed
        product.scene = self.scene
        self._bind()
        return product

    def take_stage(self, stage: Any) -> None:
        """Removes every product, because its sensor was on the former stage."""
        for path in list(self.products):
            self.remove(path)

    def end_play(self) -> None:
        """Stop: removes products and writers made since play; the others restart at external time 0."""
        super().end_play()
        self.restart()

    def restart(self) -> None:
        """The external time is 0 again: every product restarts."""
        self._forget_frames()
        for product in self.products.values():
            product.clear()
            product.restart(self.time)
            product.sensor.reset()
        self.sort()

    def _enabled_changed(self, product: RenderProduct) -> None:
        if product.enabled:
            product.restart(self.moment)
            product.sensor.reset()
        self.sort()

    def sort(self) -> None:
        """Updates which products render at ticks and which in every update, and when the next one is due."""
        super().sort()
        self._bind()

    def close(self) -> None:
        """Ends the schedule; products can still be read."""
        for product in self.history:
            product.on_enabled = _ignored

    # -- times -------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> Fraction:
        """The external time [s] that schedules follow."""
        return self._clock.time if self.multi_tick else self._loop_time()

    @property
    def sample_key(self) -> Fraction | None:
        """The key of a time sample taken now; None means the physics clock's own time."""
        return None if self.multi_tick else self._loop_time()

    @property
    def moment(self) -> Fraction:
        """The external time [s] from which a product made now exists: that of the start of a running update."""
        began = self._began_at
        if began is None:
            return self.time
        return began.time if isinstance(began, Reading) else self._loop_time() - began

    def begin_update(self, dt: Fraction) -> None:
        """Records the external time at the start of an update of `dt` [s] and ends the last update's frames."""
        self._began_at = self._clock.reading() if self.multi_tick else dt
        if self.new_frames and not self.frames_later:
            self._end_frames()

    # -- one update --------------------------------------------------------------------------------------------------

    @property
    def pending_frames(self) -> bool:
        """Whether rendered frames wait for the next update to be delivered."""
        return bool(self._pending)

    def deliver_pending(self) -> None:
        """The begin of an update if frames come later: ends the last frames and delivers the waiting ones."""
        self._end_frames()
        self._deliver_ready()

    def end_update(self) -> None:
        """Products made from here on exist from the present external time."""
        self._began_at = None

    def plan(self, target: int, *, renders_there: bool) -> None:
        """Before steps run up to count `target`: decides after which step a frozen sensor needs the poses.

        `renders_there`: rendering follows at `target` at once, so its state need not be captured.
        """
        if self._clock.rate is not self._rate:
            self._take_rate()
        self.next_capture = NEVER
        if target < self._next_due or not (self.capture_at_ticks and self.multi_tick and self.capture_state):
            return
        captures = []
        for number, product in enumerate(self.scheduled):
            schedule = product.sensor.schedule
            if isinstance(schedule, TickSchedule) and product.is_frozen and schedule.due_step <= target:
                index = schedule.newest(target)
                step = schedule.state_step(index)
                if self._clock.count < step and (step < target or not renders_there):
                    product.capture_index = index
                    product.capture, product.captured_at = None, step / self._clock.rate
                    captures.append((step, number, product))
        self._captures = sorted(captures, key=lambda entry: entry[:2], reverse=True)
        if captures:
            self.next_capture = self._captures[-1][0]

    def capture(self) -> None:
        """Stores the present poses, at step count `next_capture`, for the sensors that need them."""
        assert self.capture_state is not None
        poses = self.capture_state()
        captures, step = self._captures, self.next_capture
        while captures and captures[-1][0] == step:
            captures.pop()[2].capture = poses
        self.next_capture = captures[-1][0] if captures else NEVER

    def render_due(self, *, playing: bool = True) -> None:
        """Renders the products that are due at the present external time, in the order of their creation.

        Then delivers the frames of sensors with a latency whose time has come.
        """
        self._rendered = []
        self._render_due(playing)
        if self.capture_held:
            self._render_held()
        if self._pending and not self.frames_later:
            self._deliver_ready()

    def _render_due(self, playing: bool) -> None:
        if not self.multi_tick:
            if playing:
                self._render_every_update()
            self._held = not playing
            return
        clock = self._clock
        steps = clock.count
        if steps == self._rendered_step and clock.version == self._rendered_version:
            if self.autotrigger_idle and playing:
                self._render_idle()
            return
        self._rendered_step, self._rendered_version = steps, clock.version
        if clock.rate is not self._rate:
            self._take_rate()
        if self.eager:
            time = clock.time
            for product in tuple(self.products.values()):
                if product.enabled:
                    self._render_one(product, steps, time)
        elif steps >= self._next_due:
            for product in tuple(self.scheduled):
                self._render_if_due(product, steps)
        else:
            return
        self._find_next_due()

    def hand_over(self) -> None:
        """Gives the frames of this update to the writers of their products."""
        for product in tuple(self.new_frames):
            for writer in tuple(product.writers):
                writer(product.frame)

    def _forget_frames(self) -> None:
        self.new_frames, self._pending, self._held = [], [], True
        self._rendered_step, self._rendered_version = 0, self._clock.version
        if self._began_at is not None:
            self._began_at = self._clock.reading() if self.multi_tick else Fraction(0)

    def _take_rate(self) -> None:
        """The physics rate has changed: the external time, steps / rate, jumps, and every product restarts there."""
        count = self._clock.count
        if count and self.multi_tick and self._rate is not None and self._clock.rate != self._rate:
            for product in self.products.values():
                product.restart(count / self._clock.rate)
                product.sensor.reset()
        self._bind()

    def _bind(self) -> None:
        self._rate = self._clock.rate
        for product in self.scheduled:
            schedule = product.sensor.schedule
            if isinstance(schedule, TickSchedule):
                schedule.bind(self._rate)
        self._find_next_due()

    def _find_next_due(self) -> None:
        due = NEVER
        for product in self.scheduled:
            schedule = product.sensor.schedule
            if isinstance(schedule, TickSchedule) and schedule.due_step < due:
                due = schedule.due_step
        self._next_due = due

    def _render_one(self, product: RenderProduct, steps: int, time: Fraction) -> None:
        if product.sensor.wants_updates:
            self._advance(product, time)
        schedule = product.sensor.schedule
        if isinstance(schedule, TickSchedule):
            self._render_if_due(product, steps)
        else:
            tick = schedule.advance(time)
            if tick is not None:
                self._deliver(product, tick)

    def _render_if_due(self, product: RenderProduct, steps: int) -> None:
        schedule = product.sensor.schedule
        if isinstance(schedule, TickSchedule) and steps >= schedule.due_step:
            tick = schedule.advance_steps(steps)
            if tick is not None:
                if product.capture_index == tick.index:
                    tick.poses, tick.seen = product.capture, product.captured_at
                product.capture = None
                self._deliver(product, tick)

    def _render_idle(self) -> None:
        for product in tuple(self.eager):
            schedule = product.sensor.schedule
            if isinstance(schedule, EveryUpdate) and not schedule.rate:
                self._deliver(product, schedule.repeat(self._clock.time))

    def _render_held(self) -> None:
        """Renders the present state with each product that was not due; their schedules go on as if it had not."""
        time, rendered = self.time, self._rendered
        for product in tuple(self.products.values()):
            if product.enabled and product not in rendered:
                self._deliver(product, Tick(0, product.sensor.schedule.rate, time, time, time, held=True))

    def _render_every_update(self) -> None:
        if not self.products:
            return
        time = self._loop_time()
        for product in tuple(self.products.values()):
            if not product.enabled:
                continue
            if self._held:  # time passed while nothing was rendered: intervals restart
                product.restart(max(self.moment, product.created_at or self.moment))
            if product.sensor.wants_updates:
                self._advance(product, time)
            schedule = product.sensor.schedule
            tick: Tick | None
            if isinstance(schedule, EveryUpdate) or schedule.accumulates:
                tick = schedule.advance(time)
            else:
                tick = Tick(0, schedule.rate, time, product.advanced_to, time)
                product.advanced_to = time
            if tick is not None:
                self._deliver(product, tick)

    def _advance(self, product: RenderProduct, time: Fraction) -> None:
        start = product.advanced_to
        if time > start:
            product.advanced_to = time
            product.sensor.advance(start, time, self.scene)

    def _deliver(self, product: RenderProduct, tick: Tick) -> None:
        tick.scene = self.scene
        frame = product.sensor.render(tick)
        if frame is None:
            return
        self._rendered.append(product)
        latency = product.sensor.latency
        if latency or self.frames_later:
            self._pending.append((tick.end + latency, product, frame, self.stepped))
            return
        product.deliver(frame, stepped=self.stepped)
        self.new_frames.append(product)

    def _deliver_ready(self) -> None:
        """Delivers waiting frames whose time has come: the oldest of each product."""
        time, pending = self.time, self._pending
        self._pending = []
        for ready, product, frame, stepped in pending:
            if not product.enabled or product.scene is None:
                continue
            if ready > time or product in self.new_frames:
                self._pending.append((ready, product, frame, stepped))
            else:
                product.deliver(frame, stepped=stepped)
                self.new_frames.append(product)

    def _end_frames(self) -> None:
        for product in self.new_frames:
            product.new_frame = False
        self.new_frames = []


def _ignored(product: RenderProduct) -> None:
    """Nobody schedules it any more."""
