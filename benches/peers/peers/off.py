"""Reads OFF files of triangles."""


def read_off(path):
    with open(path) as file:
        words = file.read().split()
    vertices, faces = int(words[1]), int(words[2])
    numbers = words[4:]
    points = [tuple(map(float, numbers[3 * i : 3 * i + 3])) for i in range(vertices)]
    numbers = numbers[3 * vertices :]
    return points, [tuple(map(int, numbers[4 * i + 1 : 4 * i + 4])) for i in range(faces)]
