#include "rve-farm/assembly/stable_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace talik::farm {
namespace {

// Degrees of freedom of a disc: u_x, u_y and the surface displacement r phi, with masses m, m and m/2 (I / r^2).
constexpr double rotational_share = 0.5;

struct Normal {
    double x, y;
};

Normal normal_of(const AssemblyView& s, int c) {
    const AssemblyNumbers& n = *s.numbers;
    const double ix = s.image_x[c], iy = s.image_y[c];
    const double bx = s.x[s.second[c]] - s.x[s.first[c]] + n.cell_xx * ix + n.cell_xy * iy;
    const double by = s.y[s.second[c]] - s.y[s.first[c]] + n.cell_yx * ix + n.cell_yy * iy;
    const double length = std::hypot(bx, by);
    return {bx / length, by / length};
}

bool carries_force(const AssemblyView& s, int c) { return s.force_x[c] != 0 || s.force_y[c] != 0; }

// The larger row sum of |M^-1 K| over the discs. Each contact adds to the rows of both its discs alike: `row(c)` gives
// the sums of its entries in the rows u_x, u_y and r phi, own and other disc together, N/m.
template <class Row>
double gershgorin(const AssemblyView& s, Row&& row) {
    std::vector<std::array<double, 3>> sums(static_cast<std::size_t>(s.disc_count()), {0, 0, 0});
    for (int c = 0; c < s.contact_count(); ++c) {
        const std::array<double, 3> entries = row(c);
        for (int disc : {s.first[c], s.second[c]})
            for (std::size_t k = 0; k < 3; ++k) sums[static_cast<std::size_t>(disc)][k] += entries[k];
    }
    double largest = 0;
    for (int i = 0; i < s.disc_count(); ++i) {
        const auto& sum = sums[static_cast<std::size_t>(i)];
        largest = std::max({largest, sum[0] / s.mass[i], sum[1] / s.mass[i], sum[2] / (rotational_share * s.mass[i])});
    }
    return largest;
}

using Column = std::vector<double>; // u_x, u_y, r phi of disc 0, of disc 1, ...

// w <- M^-1/2 K M^-1/2 v: symmetric, so the iteration below converges to its largest eigenvalue from below.
void apply(const AssemblyView& s, const ContactLaw<double>& law, const Column& scale, const Column& v, Column& w) {
    std::fill(w.begin(), w.end(), 0.0);
    for (int c = 0; c < s.contact_count(); ++c) {
        if (!carries_force(s, c)) continue;
        const auto i = static_cast<std::size_t>(3 * s.first[c]), j = static_cast<std::size_t>(3 * s.second[c]);
        const Normal n = normal_of(s, c);
        const double ux = scale[j] * v[j] - scale[i] * v[i], uy = scale[j] * v[j + 1] - scale[i] * v[i + 1];
        const double rolled = scale[j + 2] * v[j + 2] + scale[i + 2] * v[i + 2];
        const double fn = law.normal_stiffness * (n.x * ux + n.y * uy);               // N
        const double ft = law.tangential_stiffness * (n.x * uy - n.y * ux - rolled);  // N
        const double fx = fn * n.x - ft * n.y, fy = fn * n.y + ft * n.x;
        w[j] += fx, w[j + 1] += fy, w[j + 2] -= ft;
        w[i] -= fx, w[i + 1] -= fy, w[i + 2] -= ft;
    }
    for (std::size_t k = 0; k < w.size(); k += 3) {
        w[k] *= scale[k], w[k + 1] *= scale[k];
        w[k + 2] *= scale[k + 2];
    }
}

} // namespace

double omega_squared_bound_of_list(const AssemblyView& s, const ContactLaw<double>& law) {
    const double kn = law.normal_stiffness, kt = law.tangential_stiffness;
    // Largest row sum of kn n n^T + kt t t^T over the directions: mean plus half difference times sqrt(2).
    const double translation = (kn + kt) / 2 + std::abs(kn - kt) / std::sqrt(2.0);
    return gershgorin(s, [&](int) -> std::array<double, 3> {
        return {2 * (translation + kt), 2 * (translation + kt), 2 * (std::sqrt(2.0) * kt + kt)};
    });
}

double omega_squared_bound_of_contacts(const AssemblyView& s, const ContactLaw<double>& law) {
    const double kn = law.normal_stiffness, kt = law.tangential_stiffness;
    return gershgorin(s, [&](int c) -> std::array<double, 3> {
        if (!carries_force(s, c)) return {0, 0, 0};
        const Normal n = normal_of(s, c);
        const double x = std::abs(n.x), y = std::abs(n.y), coupling = std::abs(kn - kt) * x * y;
        return {2 * (kn * x * x + kt * y * y + coupling + kt * y), 2 * (kn * y * y + kt * x * x + coupling + kt * x),
                2 * kt * (x + y + 1)};
    });
}

double omega_squared_of_contacts(const AssemblyView& s, const ContactLaw<double>& law) {
    const std::size_t size = 3 * static_cast<std::size_t>(s.disc_count());
    Column scale(size), v(size), w(size);
    for (std::size_t i = 0; i < size; i += 3) {
        const double mass = s.mass[i / 3];
        scale[i] = scale[i + 1] = 1 / std::sqrt(mass);
        scale[i + 2] = 1 / std::sqrt(rotational_share * mass);
    }
    for (std::size_t k = 0; k < size; ++k) v[k] = std::sin(1.0 + 0.7 * static_cast<double>(k)); // no symmetry of the network
    double omega_squared = 0;
    for (int iteration = 0; iteration < 2000; ++iteration) {
        double norm = 0;
        for (double component : v) norm += component * component;
        norm = std::sqrt(norm);
        if (!(norm > 0)) return 0;
        for (double& component : v) component /= norm;
        apply(s, law, scale, v, w);
        double rayleigh = 0;
        for (std::size_t k = 0; k < size; ++k) rayleigh += v[k] * w[k];
        const bool settled = iteration > 50 && std::abs(rayleigh - omega_squared) < 1e-7 * rayleigh;
        omega_squared = rayleigh;
        if (settled) break;
        v.swap(w);
    }
    return omega_squared;
}

double stable_step(double omega_squared) {
    return omega_squared > 0 ? 2 / std::sqrt(omega_squared) : std::numeric_limits<double>::infinity();
}

bool is_stable(AssemblyView& s, const ContactLaw<double>& contact, double sub_step) {
    AssemblyNumbers& n = *s.numbers;
    if (n.omega_squared_bound < 0) n.omega_squared_bound = omega_squared_bound_of_list(s, contact);
    return sub_step <= stable_step(n.omega_squared_bound) || sub_step <= stable_step(omega_squared_bound_of_contacts(s, contact)) ||
           sub_step <= stable_step(omega_squared_of_contacts(s, contact));
}

} // namespace talik::farm
