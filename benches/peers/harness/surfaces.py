"""The six surfaces of Tong & Kim 2009, with boxes that hold them closely: every program gets the same one."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Surface:
    name: str
    formula: str
    # x, y, z: lowest and highest.
    box: tuple[float, float, float, float, float, float]
    # Of the box around the surface itself: errors are shares of it.
    diagonal: float
    # Vertices - edges + faces of the right result.
    euler: int

    def request(self, parameter, output="-"):
        """The words that ask a program for this surface."""
        return [self.name, self.formula, " ".join(map(str, self.box)), parameter, output]


def cube(half):
    return (-half, half) * 3


SURFACES = [
    Surface("torus", "(sqrt(x^2+y^2)-5)^2+z^2-1", (-6.5, 6.5, -6.5, 6.5, -1.5, 1.5), 17.088, 0),
    Surface("dodeca", "x^6+y^6+z^6+20(x^4y^2+y^4z^2+z^4x^2)-1", cube(1.1), 3.464, 2),
    Surface(
        "dtorus",
        "x^8-2x^6+x^4+2x^4y^2-2x^2y^2+y^4+z^2-0.04",
        (-1.3, 1.3, -0.8, 0.8, -0.35, 0.35),
        2.577,
        -2,
    ),
    Surface("mcmullen", "(x^2+1)(y^2+1)(z^2+1)+8xyz-2", cube(1.95), 6.108, 2),
    Surface(
        "chair",
        "(x^2+y^2+z^2-0.95*25)^2-0.8*((z-5)^2-2x^2)*((z+5)^2-2y^2)",
        cube(5.5),
        17.015,
        -4,
    ),
    Surface(
        "decocube",
        "((x^2+y^2-0.64)^2+(z^2-1)^2)*((y^2+z^2-0.64)^2+(x^2-1)^2)*((z^2+x^2-0.64)^2+(y^2-1)^2)-0.02",
        cube(1.4),
        3.712,
        -24,
    ),
]
