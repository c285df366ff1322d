"""Searches the number of a program (resolution, tolerance, depth) that just reaches an error."""


class Resolution:
    """A number n that may be anything: the error falls as n^-order."""

    def __init__(self, first, order, whole=True, to_parameter=lambda n: n):
        self.first, self.order, self.whole, self.to_parameter = first, order, whole, to_parameter

    # Errors between this and 1 times the target meet it "just".
    JUST = 0.85
    AIM = 0.93
    TRIES = 10

    def finer(self, n, error, target):
        """Where the error should be just under the target, if it is `error` at n."""
        return n * (error / (self.AIM * target)) ** (1 / self.order)

    def find(self, attempt, target, known):
        """The coarsest result that was seen to keep the target, of `attempt(parameter)`; None if there is none.

        `known` is what was found for a larger target, or None."""
        n = self.finer(known["n"], known["error"], target) if known else self.first(target)
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
            n = self.finer(n, error, target)
            if not missed < n < kept:
                n = (missed * kept) ** 0.5 if missed and kept < float("inf") else max(n, 1.3 * missed)
            if kept - missed <= (1 if self.whole else 0.03 * missed):
                return best
        return best


class Ladder:
    """A few values, coarsest first; the first that keeps the target counts."""

    def __init__(self, values):
        self.values = values

    def find(self, attempt, target, _known):
        for value in self.values(target):
            result = attempt(value)
            if result is None:
                return None
            if result["error"] <= target:
                return result
        return None
