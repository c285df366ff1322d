"""Searches the number of a program (resolution, tolerance, depth) that just reaches an error."""


class Resolution:
    """A number n that may be anything: the error falls as n^-order."""

    def __init__(self, first, order, whole=True, to_parameter=lambda n: n):
        self.first, self.order, self.whole, self.to_parameter = first, order, whole, to_parameter

    # Errors between this and 1 times the target meet it "just".
    JUST = 0.85
    AIM = 0.93
    TRIES = 10

    def find(self, attempt, target, hint):
        """The coarsest result that was seen to keep the target, of `attempt(parameter)`; None if there is none."""
        n = hint * 1.0 if hint else self.first(target)
        missed, kept, best = 0.0, float("inf"), None
        for _ in range(self.TRIES):
            n = round(n) if self.whole else n
            result = attempt(self.to_parameter(n))
            if result is None:
                # Too long or too large: only a coarser one is left to try.
                return best
            error = result["error"]
            if error <= target:
                if n < kept:
                    kept, best = n, dict(result, n=n)
                if error >= self.JUST * target:
                    return best
            else:
                missed = max(missed, n)
            n = n * (error / (self.AIM * target)) ** (1 / self.order)
            if not missed < n < kept:
                n = (missed * kept) ** 0.5 if missed and kept < float("inf") else max(n, 1.3 * missed)
            if kept - missed <= (1 if self.whole else 0.03 * missed):
                return best
        return best


class Ladder:
    """A few values, coarsest first; the first that keeps the target counts."""

    order = None

    def __init__(self, values):
        self.values = values

    def find(self, attempt, target, _hint):
        for value in self.values(target):
            result = attempt(value)
            if result is None:
                return None
            if result["error"] <= target:
                return dict(result, n=value)
        return None
