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

Normal normal_of(const ContactGeometry& g) { return {g.x / g.length, g.y / g.length}; }

// Rows and columns may be scaled against one another without moving an eigenvalue: the rotations, whose row sums are the
// largest (their mass is half), are scaled so that both kinds of rows come to about the same sum. That is less where the
// coupling of a disc's own displacement and rotation is not allowed to cancel.
constexpr double rotation_scale_of_contacts = 4, rotation_scale_of_list = 2;

// What a contact adds to the rows of each of its discs, N/m: diagonal and neighbour's block together, but for the
// coupling of a disc's own displacement and rotation, k_t t with the sign of the end: it largely cancels over the contacts
// around a disc, and is summed with its sign.
struct GershgorinRow {
    double translation_x = 0, translation_y = 0, rotation = 0; // absolute sums
    double own_x = 0, own_y = 0;                               // signed sums
};

// The largest row sum of |M^-1 K|, 1/s^2. `row(c)` gives the row of the contact's first disc; the second's differs by the
// sign of the coupling.
template <class Row>
double gershgorin(const AssemblyView& s, double rotation_scale, Row&& row) {
    thread_local std::vector<GershgorinRow> sums; // grows to the largest RVE it has met
    sums.assign(static_cast<std::size_t>(s.disc_count()), GershgorinRow{});
    for (int c = 0; c < s.contact_count(); ++c) {
        const GershgorinRow entry = row(c);
        double sign = 1;
        for (int disc : {s.first[c], s.second[c]}) {
            GershgorinRow& sum = sums[static_cast<std::size_t>(disc)];
            sum.translation_x += entry.translation_x;
            sum.translation_y += entry.translation_y;
            sum.rotation += entry.rotation;
            sum.own_x += sign * entry.own_x;
            sum.own_y += sign * entry.own_y;
            sign = -1;
        }
    }
    double largest = 0;
    for (int i = 0; i < s.disc_count(); ++i) {
        const GershgorinRow& sum = sums[static_cast<std::size_t>(i)];
        const double own_x = std::abs(sum.own_x), own_y = std::abs(sum.own_y);
        const double translation = std::max(sum.translation_x + rotation_scale * own_x, sum.translation_y + rotation_scale * own_y);
        const double rotation = sum.rotation + (own_x + own_y) / rotation_scale;
        largest = std::max({largest, translation / s.mass[i], rotation / (rotational_share * s.mass[i])});
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
        const Normal n = normal_of(geometry_of(s, c));
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
    // In the worst direction: kn n n^T + kt t t^T has row sums of at most the mean plus half the difference times sqrt(2),
    // and nothing cancels.
    const double block = (kn + kt) / 2 + std::abs(kn - kt) / std::sqrt(2.0);
    const double rotation_scale = rotation_scale_of_list;
    const double translation = 2 * (block + kt * rotation_scale), rotation = 2 * (kt + std::sqrt(2.0) * kt / rotation_scale);
    return gershgorin(s, rotation_scale, [&](int) { return GershgorinRow{translation, translation, rotation, 0, 0}; });
}

double omega_squared_bound_of_contacts(const AssemblyView& s, const ContactLaw<double>& law) {
    const double kn = law.normal_stiffness, kt = law.tangential_stiffness;
    const double rotation_scale = rotation_scale_of_contacts;
    return gershgorin(s, rotation_scale, [&](int c) {
        if (!carries_force(s, c)) return GershgorinRow{};
        const Normal n = normal_of(geometry_of(s, c));
        const double x = std::abs(n.x), y = std::abs(n.y), coupling = std::abs(kn - kt) * x * y;
        return GershgorinRow{2 * (kn * x * x + kt * y * y + coupling) + kt * y * rotation_scale, // t = (-n_y, n_x)
                             2 * (kn * y * y + kt * x * x + coupling) + kt * x * rotation_scale,
                             2 * kt + kt * (x + y) / rotation_scale, -kt * n.y, kt * n.x};
    });
}

double omega_squared_of_contacts(const AssemblyView& s, const ContactLaw<double>& law) {
    const std::size_t size = 3 * static_cast<std::size_t>(s.disc_count());
    thread_local Column scale, v, w; // grow to the largest RVE they have met
    for (Column* column : {&scale, &v, &w}) column->resize(size);
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

bool is_stable_by_list(AssemblyView& s, const ContactLaw<double>& contact, double sub_step) {
    AssemblyNumbers& n = *s.numbers;
    if (n.omega_squared_bound < 0) n.omega_squared_bound = omega_squared_bound_of_list(s, contact);
    return sub_step <= stable_step(n.omega_squared_bound);
}

bool is_stable(AssemblyView& s, const ContactLaw<double>& contact, double sub_step) {
    return is_stable_by_list(s, contact, sub_step) || sub_step <= stable_step(omega_squared_bound_of_contacts(s, contact)) ||
           sub_step <= stable_step(omega_squared_of_contacts(s, contact));
}

} // namespace talik::farm
