"""One RVE in YADE, timed: run by tools/compare-peers as `yade -n -x -j1 shear_yade.py OPTIONS.json`.

Constant-area shear to and fro, one window each way; every window is one O.run(steps, True), with the wall time around it.
The options: discs (x, y, radius, vx, vy, wz), contacts (id1, id2, ftx, fty), cell (m), thickness (m), density (kg/m^3),
stiffness (k_n = k_t, N/m), friction, damping, dt (s), verlet_distance (m), rate (1/s), warm, steps, windows, answer (file).
"""
import json
import math
import sys
import time

from yade import *  # noqa: F401,F403  the package's own way

with open(sys.argv[-1]) as file:
    o = json.load(file)
depth = 6 * max(disc["radius"] for disc in o["discs"])  # of the cell: YADE wants more than two discs

O.periodic = True
O.cell.hSize = Matrix3(o["cell"][0], 0, 0, 0, o["cell"][1], 0, 0, 0, depth)
for i, disc in enumerate(o["discs"]):
    radius = disc["radius"]
    # With young = k/radius and poisson = 1 the package's harmonic means give k_n = k_t = k at every contact.
    material = FrictMat(density=o["density"], young=o["stiffness"] / radius, poisson=1.0, frictionAngle=math.atan(o["friction"]), label=f"m{i}")
    body = utils.sphere((disc["x"], disc["y"], depth / 2), radius, material=material)
    body.state.mass = o["density"] * math.pi * radius**2 * o["thickness"]  # a disc's
    body.state.inertia = Vector3(1, 1, 1) * 0.5 * body.state.mass * radius**2
    body.state.vel, body.state.angVel = Vector3(disc["vx"], disc["vy"], 0), Vector3(0, 0, disc["wz"])
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=o["verlet_distance"], allowBiggerThanPeriod=True),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(damping=o["damping"], gravity=(0, 0, 0)),
]


def shear(rate, steps):
    O.cell.velGrad = Matrix3(rate, 0, 0, 0, -rate, 0, 0, 0, 0)
    begin = time.perf_counter()
    O.run(steps, True)
    return time.perf_counter() - begin


def state():
    touching = [i for i in O.interactions if i.isReal and i.geom.penetrationDepth > 0]
    stress = utils.getStress()
    area = O.cell.hSize[0, 0] * O.cell.hSize[1, 1]
    return {"contacts": len(touching), "pressure": -0.5 * (stress[0, 0] + stress[1, 1]) * O.cell.volume / (area * o["thickness"])}


O.dt = 1e-3 * o["dt"]  # one step that moves next to nothing: it finds the contacts
O.run(1, True)
for contact in o["contacts"]:
    found = O.interactions[contact["id1"], contact["id2"]]
    sign = 1 if found.id1 == contact["id1"] else -1
    found.phys.shearForce = sign * Vector3(contact["ftx"], contact["fty"], 0)
answer = {"begin": state()}
O.dt = o["dt"]
shear(o["rate"], o["warm"])
answer["seconds"] = [shear(o["rate"] * (-1 if k % 2 == 0 else 1), o["steps"]) for k in range(o["windows"])]
answer["end"] = state()
with open(o["answer"], "w") as file:
    json.dump(answer, file)
