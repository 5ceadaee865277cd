"""Mohr-Coulomb with a cohesion that grows with the ice, as a law of one's own: it answers a real mpm-driver, a chunk of
points at a time (numpy throughout). Elastic up to the yield surface, then a return along a non-associated flow rule.

In the plane, tension positive: p = (s_xx + s_yy) / 2 and R the radius of Mohr's circle,
    yield      f = R + p sin(phi) - c cos(phi) <= 0,          c = c_thawed + (c_frozen - c_thawed) S_i
    flow       g = R + p sin(psi)
s_zz is taken to lie between the two principal stresses of the plane, so that it takes no part.
"""
import numpy as np
import talik_exchange as talik


class MohrCoulomb(talik.Law):
    name = "Mohr-Coulomb with ice, in Python"
    requests = ("displacement_gradient_increment", "ice_saturation")
    answers = ("stress", "stiffness", "stored_energy", "friction_dissipation", "work")

    def __init__(self, young=50e6, poisson=0.3, friction=30.0, dilation=5.0, cohesion_thawed=5e3, cohesion_frozen=50e3):
        self.shear = young / (2 * (1 + poisson))                                  # G, Pa
        self.bulk = young / (2 * (1 + poisson) * (1 - 2 * poisson))               # lambda + G: p over the area strain, Pa
        self.sin_phi, self.cos_phi = np.sin(np.radians(friction)), np.cos(np.radians(friction))
        self.sin_psi = np.sin(np.radians(dilation))
        self.cohesion = cohesion_thawed, cohesion_frozen                          # Pa

    def strength(self, confinement, ice):
        """Largest principal compression that the confinement can hold, Pa, compression positive."""
        ratio = (1 + self.sin_phi) / (1 - self.sin_phi)
        return ratio * confinement + 2 * self.cohesion_at(ice) * np.sqrt(ratio)

    def cohesion_at(self, ice):
        thawed, frozen = self.cohesion
        return thawed + (frozen - thawed) * ice

    def configure(self, setup):
        self.stress = setup.initial_stress
        self.volume = setup.volume                                                # of an RVE, m^3: what energies refer to
        self.work, self.dissipation = np.zeros(setup.rves), np.zeros(setup.rves)
        self.stored_at_start = self.elastic_energy(self.stress)
        return self.answers_of(slice(None))

    def elastic_energy(self, stress):
        """Per volume, J/m^3."""
        p, radius = mean_and_radius(stress)
        return p**2 / (2 * self.bulk) + radius**2 / (2 * self.shear)

    def answers_of(self, ids):
        stress = self.stress[ids]
        return {"stress": stress, "stiffness": np.full(len(stress), self.bulk + self.shear),
                "stored_energy": (self.elastic_energy(stress) - self.stored_at_start[ids]) * self.volume[ids],
                "friction_dissipation": self.dissipation[ids], "work": self.work[ids]}

    def answer(self, batch):
        h, ids = batch["displacement_gradient_increment"], batch.ids
        before = self.stress[ids]
        e_xx, e_yy, gamma = h[:, 0], h[:, 3], h[:, 1] + h[:, 2]

        stress = rotated(before, 0.5 * (h[:, 2] - h[:, 1]))                       # the material turns with the spin
        stress[:, 0] += self.bulk * (e_xx + e_yy) + self.shear * (e_xx - e_yy)
        stress[:, 1] += self.bulk * (e_xx + e_yy) - self.shear * (e_xx - e_yy)
        stress[:, 2] += self.shear * gamma

        p, radius = mean_and_radius(stress)
        cohesion = self.cohesion_at(batch["ice_saturation"])
        beyond = np.maximum(radius + p * self.sin_phi - cohesion * self.cos_phi, 0.0)
        slip = beyond / (self.shear + self.bulk * self.sin_phi * self.sin_psi)    # plastic multiplier, -
        new_radius, new_p = radius - self.shear * slip, p - self.bulk * self.sin_psi * slip
        apex = new_radius < 0.0                                                   # pulled beyond the cone: to its tip
        new_radius, new_p = np.where(apex, 0.0, new_radius), np.where(apex, cohesion * self.cos_phi / self.sin_phi, new_p)
        ratio = np.divide(new_radius, radius, out=np.ones_like(radius), where=radius > 0.0)
        half = 0.5 * (stress[:, 0] - stress[:, 1]) * ratio
        stress = np.stack([new_p + half, new_p - half, stress[:, 2] * ratio], axis=1)

        self.stress[ids] = stress
        middle = 0.5 * (before + stress)
        work = (middle[:, 0] * e_xx + middle[:, 1] * e_yy + middle[:, 2] * gamma) * self.volume[ids]
        plastic = (new_radius * (radius - new_radius) / self.shear + new_p * (p - new_p) / self.bulk) * self.volume[ids]
        self.work[ids] += work
        self.dissipation[ids] += plastic
        return self.answers_of(ids)


def mean_and_radius(stress):
    return 0.5 * (stress[:, 0] + stress[:, 1]), np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])


def rotated(stress, angle):
    """Components of a stress that turned with the material by `angle` (counter-clockwise)."""
    c, s = np.cos(angle), np.sin(angle)
    xx, yy, xy = stress.T
    return np.stack([c * c * xx + s * s * yy - 2 * c * s * xy, s * s * xx + c * c * yy + 2 * c * s * xy,
                     c * s * (xx - yy) + (c * c - s * s) * xy], axis=1)
