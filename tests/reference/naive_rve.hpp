#pragma once
// An RVE written from the equations alone, with simplicity and clarity in mind: fixed axes, every pair and every image in
// every sub-step, history in a map, matrices from Eigen. It shares no code with the farm; both obey physics.md.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <Eigen/Dense>
#include <unsupported/Eigen/MatrixFunctions>

#include "common/packing/packing.hpp"
#include "common/physics/rve_parameters.hpp"

namespace talik::reference {

class NaiveRve {
public:
    NaiveRve(const RveParameters& parameters, const Packing& packing) : p_(parameters), cell_(packing.cell) {
        for (int i = 0; i < packing.disc_count(); ++i) {
            const auto k = static_cast<std::size_t>(i);
            discs_.push_back({Vector(packing.x[k], packing.y[k]), Vector::Zero(), 0.0, packing.radius[k], Vector::Zero(), 0.0});
        }
        update_contacts(discs_, cell_, Matrix::Identity(), 0.0); // the forces of the positions
        friction_dissipation = bond_dissipation = work = 0;
    }

    // n sub-steps of a macro step with displacement-gradient increment dt L (Eqs. 44-46).
    void advance(const Matrix& increment, double time_increment, int substeps) {
        const double dt = time_increment / substeps;
        const Matrix gradient = increment / substeps;
        const Matrix motion = gradient.exp(); // G = exp(dt L)
        const Eigen::JacobiSVD<Matrix> svd(motion, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const Matrix rotation = svd.matrixU() * svd.matrixV().transpose(); // G = R U
        for (int k = 0; k < substeps; ++k) {
            const std::vector<Disc> before = discs_;
            const Matrix cell_before = cell_;
            for (Disc& disc : discs_) {
                kick(disc, dt);
                disc.velocity = rotation * disc.velocity; // constant in co-rotated axes
                disc.position = motion * disc.position + dt * disc.velocity;
            }
            cell_ = motion * cell_;
            frame_ = rotation * frame_;
            update_contacts(before, cell_before, rotation, dt);
        }
    }

    // Eq. (49), tension positive: -(1/V) sum f x b, symmetric part, Pa.
    Matrix stress() const {
        Matrix sum = Matrix::Zero();
        for (const auto& [key, contact] : contacts_) sum += contact.force * contact.branch.transpose();
        return -(sum + sum.transpose()) / 2 / (cell_.determinant() * p_.thickness);
    }

    void bond_all() {
        for (auto& [key, contact] : contacts_)
            if (contact.force.norm() > 0) contact.bonded = true;
    }
    int bonds() const {
        int count = 0;
        for (const auto& [key, contact] : contacts_) count += contact.bonded;
        return count;
    }

    double ice_saturation = 1;
    double friction_dissipation = 0, bond_dissipation = 0, damping_dissipation = 0, work = 0; // J

private:
    struct Disc {
        Vector position, velocity; // m; v_f, m/s
        double spin, radius;       // relative to the frame, 1/s; m
        Vector force;              // N
        double torque;             // N m
    };
    struct Contact {
        Vector force = Vector::Zero(), branch = Vector::Zero(); // on the second disc, N; m
        double tangential = 0;                                  // N
        bool bonded = false;
    };
    using Key = std::tuple<int, int, int, int>; // first, second, image

    // Cundall's damping, per component in co-rotated axes, on velocity and spin.
    void kick(Disc& disc, double dt) {
        const double mass = p_.grain_density * M_PI * disc.radius * disc.radius * p_.thickness; // rho pi r^2 t, kg
        const double inertia = mass * disc.radius * disc.radius / 2;                            // m r^2 / 2, kg m^2
        const Vector force = frame_.transpose() * disc.force;
        Vector velocity = frame_.transpose() * disc.velocity;
        for (int a = 0; a < 2; ++a) velocity[a] = kicked(force[a], velocity[a], mass, dt);
        disc.velocity = frame_ * velocity;
        disc.spin = kicked(disc.torque, disc.spin, inertia, dt);
    }
    double kicked(double force, double velocity, double mass, double dt) {
        const double power = force * (velocity + dt / 2 * force / mass);
        const double drag = power == 0 ? 0 : p_.damping * force * (power > 0 ? 1 : -1);
        const double next = velocity + dt * (force - drag) / mass;
        damping_dissipation += drag * (velocity + next) / 2 * dt;
        return next;
    }

    void update_contacts(const std::vector<Disc>& before, const Matrix& cell_before, const Matrix& rotation, double dt) {
        for (Disc& disc : discs_) disc.force.setZero(), disc.torque = 0;
        const int count = static_cast<int>(discs_.size());
        for (int i = 0; i < count; ++i)
            for (int j = i; j < count; ++j)
                for (int a = -2; a <= 2; ++a)
                    for (int b = -2; b <= 2; ++b) {
                        if (i == j && (b < 0 || (b == 0 && a <= 0))) continue; // one of two directions
                        update_pair({i, j, a, b}, before, cell_before, rotation, dt);
                    }
    }

    void update_pair(const Key& key, const std::vector<Disc>& before, const Matrix& cell_before, const Matrix& rotation,
                     double dt) {
        const auto [i, j, a, b] = key;
        Disc& first = discs_[static_cast<std::size_t>(i)];
        Disc& second = discs_[static_cast<std::size_t>(j)];
        const Vector image(a, b);
        const Vector branch = second.position + cell_ * image - first.position; // m
        const double overlap = first.radius + second.radius - branch.norm();    // m
        const auto found = contacts_.find(key);
        if (overlap <= 0 && found == contacts_.end()) return;
        Contact& contact = contacts_[key];

        // Displacement relative to the rotating frame, and its part that comes from the cell's stretch.
        const Vector old_branch = before[static_cast<std::size_t>(j)].position + cell_before * image -
                                  before[static_cast<std::size_t>(i)].position;
        const Vector moved = branch - rotation * old_branch;
        const Vector affine = moved - dt * (second.velocity - first.velocity);
        const Vector normal = branch.normalized();
        const Vector tangent(-normal.y(), normal.x());
        const double arm_first = first.radius - overlap / 2, arm_second = second.radius - overlap / 2;
        // Half way through the sub-step: the mean length of the branch times what it has turned, less what the discs roll on
        // the lever arms of that moment.
        const Vector from = rotation * old_branch;
        const double turned = std::atan2(from.x() * branch.y() - from.y() * branch.x(), from.dot(branch)); // rad
        const double middle = (from.norm() + branch.norm()) / 2, half_opening = (branch.norm() - from.norm()) / 2; // m
        const double slip = middle * turned - dt * ((arm_first - half_opening / 2) * first.spin + (arm_second - half_opening / 2) * second.spin); // m

        double fn = p_.contact.normal_stiffness * overlap;                            // Eq. (5a)
        const double trial = contact.tangential - p_.contact.tangential_stiffness * slip; // Eq. (5b)
        const double trial_fn = fn;
        double ft = trial;
        bool broke = false;
        if (contact.bonded) {
            const double r = std::min(first.radius, second.radius), beta = p_.bond->strength_factor * ice_saturation; // Eq. (8)
            broke = -fn > beta * p_.bond->normal_strength * r * r ||                  // Eq. (6)
                    std::abs(ft) > beta * p_.bond->tangential_strength * r * r;       // Eq. (7)
            if (broke) contact.bonded = false;
        }
        if (!contact.bonded) {
            fn = std::max(fn, 0.0);
            const double limit = p_.contact.friction * fn; // Eq. (5c)
            ft = std::clamp(ft, -limit, limit);
        }
        const double kn = p_.contact.normal_stiffness, kt = p_.contact.tangential_stiffness;
        if (broke)
            bond_dissipation += (trial_fn * trial_fn - fn * fn) / (2 * kn) + (trial * trial - ft * ft) / (2 * kt) +
                                ((trial_fn - fn) * 2 * half_opening + (trial - ft) * slip) / 2;
        else friction_dissipation += (contact.tangential + ft) / 2 * (trial - ft) / kt;

        const Vector force = fn * normal + ft * tangent;
        work -= (rotation * contact.force + force).dot(affine) / 2; // J
        contact = {force, branch, ft, contact.bonded};
        first.force -= force, second.force += force;
        first.torque -= arm_first * ft, second.torque -= arm_second * ft;
        if (overlap <= 0 && !contact.bonded) contacts_.erase(key);
    }

    RveParameters p_;
    Matrix cell_;
    Matrix frame_ = Matrix::Identity();
    std::vector<Disc> discs_;
    std::map<Key, Contact> contacts_;
};

} // namespace talik::reference
