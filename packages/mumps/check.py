#!/usr/bin/env python3
"""Checks conserva-mumps alone, on matrices with known inverses: python3 check.py PROGRAM [RANKS]..."""

import array
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time

HEAD = struct.Struct("=8q")
STRUCTURE, FACTORIZE, SOLVE, FREE, FINISH = range(1, 6)
MPIRUN = os.environ.get("MPIRUN", "mpirun --allow-run-as-root --oversubscribe --bind-to none").split()


class Ranks:
    """Processes of conserva-mumps with the connection to rank 0."""

    def __init__(self, program, ranks):
        self.folder = tempfile.TemporaryDirectory()
        path = os.path.join(self.folder.name, "socket")
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(path)
        listener.listen(1)
        listener.settimeout(60)
        self.process = subprocess.Popen([*MPIRUN, "-n", str(ranks), program, path], stderr=subprocess.DEVNULL)
        self.connection = listener.accept()[0]
        self.connection.settimeout(60)
        magic, self.ranks = HEAD.unpack(self.receive(HEAD.size))[:2]
        assert magic == 0x31304D554D4F43 and self.ranks == ranks
        self.version = self.receive(32).rstrip(b"\0").decode()

    def receive(self, size):
        data = b""
        while len(data) < size:
            part = self.connection.recv(size - len(data))
            if not part:
                raise EOFError
            data += part
        return data

    def send(self, *head, data=b""):
        self.connection.sendall(HEAD.pack(*head, *[0] * (8 - len(head))) + data)

    def structure(self, number, symmetric, size, entries):
        rows, columns = (array.array("i", [entry[k] + 1 for entry in entries]).tobytes() for k in (0, 1))
        self.send(STRUCTURE, number, symmetric, size, len(entries), data=rows + columns)

    def factorize(self, number, values):
        self.send(FACTORIZE, number, data=array.array("d", values).tobytes())
        answer = HEAD.unpack(self.receive(HEAD.size))
        return answer, array.array("d", self.receive(8 * self.ranks)).tolist()

    def solve(self, number, size, rights):
        self.send(SOLVE, number, len(rights) // size, data=array.array("d", rights).tobytes())
        answer = HEAD.unpack(self.receive(HEAD.size))
        return answer, array.array("d", self.receive(8 * len(rights))).tolist() if answer[0] == 0 else None

    def end(self):
        self.send(FINISH)
        return self.process.wait(60)


def chain(size):
    """Lower triangle of the second difference: the solution for a unit load at k is min((i+1)(n-k), (k+1)(n-i))/(n+1)."""
    entries = [(i, i) for i in range(size)] + [(i + 1, i) for i in range(size - 1)]
    return entries, [2.0] * size + [-1.0] * (size - 1)


def green(size, i, k):
    return min((i + 1) * (size - k), (k + 1) * (size - i)) / (size + 1)


def check(program, ranks):
    world = Ranks(program, ranks)
    size, loaded = 500, (3, 250, 499)
    entries, values = chain(size)
    rights = [1.0 if i == k else 0.0 for k in loaded for i in range(size)]
    # Symmetric, and the whole matrix as an unsymmetric one; two matrices at a time, several right sides, other values of a structure.
    whole = entries + [(k, i) for i, k in entries if i != k]
    world.structure(1, 1, size, entries)
    world.structure(2, 0, size, whole)
    for factor in (1.0, 4.0):
        for number, given in ((1, values), (2, values + [-1.0] * (size - 1))):
            answer, memory = world.factorize(number, [factor * x for x in given])
            assert answer[0] == 0 and answer[3] == 0 and len(memory) == ranks, answer
            assert number == 2 or answer[2] == 0, "a positive definite matrix has no negative pivots"
            answer, solved = world.solve(number, size, rights)
            exact = [green(size, i, k) / factor for k in loaded for i in range(size)]
            assert max(abs(x - y) for x, y in zip(solved, exact)) < 1e-10 * max(exact)
    # A saddle point: nodes i with stiffness 1, and multipliers that hold pairs of them together; as many negative pivots as multipliers.
    pairs = 40
    saddle = [(i, i) for i in range(2 * pairs)] + [(2 * pairs + m, 2 * m + j) for m in range(pairs) for j in (0, 1)]
    world.structure(3, 1, 3 * pairs, saddle)
    answer, _ = world.factorize(3, [1.0] * (2 * pairs) + [1.0, -1.0] * pairs)
    assert answer[:4] == (0, 0, pairs, 0), answer
    _, solved = world.solve(3, 3 * pairs, [2.0, 0.0] * pairs + [0.0] * pairs)
    assert max(abs(x - 1.0) for x in solved) < 1e-12, "both nodes move by 1, and the multiplier is 1"
    # Singular: the chain without supports, whose null vector is constant.
    answer, _ = world.factorize(1, [1.0] + [2.0] * (size - 2) + [1.0] + [-1.0] * (size - 1))
    assert answer[0] == -10 or answer[3] == 1, f"a null pivot: {answer}"
    world.send(FREE, 2)
    assert world.factorize(7, [])[0][0] == -1001, "a matrix that is not known"
    assert world.end() == 0
    # A rank that is killed ends the connection, and all ranks.
    world = Ranks(program, ranks)
    others = subprocess.run(["pgrep", "-P", str(world.process.pid)], capture_output=True, text=True).stdout.split()
    os.kill(int(others[-1]), 9)
    begun = time.time()
    try:
        world.receive(1)
        raise AssertionError("the connection goes on without a rank")
    except EOFError:
        assert time.time() - begun < 20
    assert world.process.wait(60) != 0
    # The end of the connection without a word ends all ranks in order.
    world = Ranks(program, ranks)
    world.connection.close()
    assert world.process.wait(60) == 0
    print(f"{ranks} ranks of MUMPS {world.version}: passed")


for count in sys.argv[2:] or ["1", "2", "4"]:
    check(os.path.abspath(sys.argv[1]), int(count))
