#pragma once
// A pack of lanes with the operators of a number, over Highway, so that the text of a law serves both. Included only by
// the kernel files, each of which is compiled for one instruction level: everything here lives in a namespace of that
// level, so that no code for a newer machine can reach an older one through the linker.
#define HWY_COMPILE_ONLY_STATIC
#define HWY_DISABLE_PCLMUL_AES
#include <hwy/highway.h>

#include <cstdint>

#include "rve-farm/physics/real.hpp"

namespace talik::farm::inline HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class T, int N>
struct Mask {
    hn::Mask<hn::ScalableTag<T>> m[N];
    friend HWY_INLINE Mask operator&(Mask a, Mask b) { return both(a, b, [](auto x, auto y) HWY_ATTR { return hn::And(x, y); }); }
    friend HWY_INLINE Mask operator|(Mask a, Mask b) { return both(a, b, [](auto x, auto y) HWY_ATTR { return hn::Or(x, y); }); }
    friend HWY_INLINE Mask operator!(Mask a) { return both(a, a, [](auto x, auto) HWY_ATTR { return hn::Not(x); }); }

private:
    template <class F>
    static HWY_INLINE Mask both(Mask a, Mask b, F&& f) {
        Mask r;
        for (int k = 0; k < N; ++k) r.m[k] = f(a.m[k], b.m[k]);
        return r;
    }
};

// N vectors as one number. Two of them in turn keep a core busy that would wait for the long chain of one contact.
template <class T, int N = 1>
struct Pack {
    using D = hn::ScalableTag<T>;
    using V = hn::Vec<D>;
    static constexpr int lanes_of_a_vector = static_cast<int>(HWY_LANES(T)), lanes = N * lanes_of_a_vector;

    V v[N];

    HWY_INLINE Pack() { for (V& part : v) part = hn::Zero(D()); }
    HWY_INLINE Pack(V vector) requires(N == 1) : v{vector} {}
    HWY_INLINE Pack(double number) { for (V& part : v) part = hn::Set(D(), static_cast<T>(number)); } // the same in every lane
    template <int M>
    HWY_INLINE Pack(const Pack<T, M>& one) requires(M == 1 && N > 1) { for (V& part : v) part = one.v[0]; }
    static HWY_INLINE Pack load(const T* aligned) {
        Pack p;
        for (int k = 0; k < N; ++k) p.v[k] = hn::Load(D(), aligned + k * lanes_of_a_vector);
        return p;
    }
    HWY_INLINE void store(T* aligned) const {
        for (int k = 0; k < N; ++k) hn::Store(v[k], D(), aligned + k * lanes_of_a_vector);
    }
    HWY_INLINE double sum() const {
        V all = v[0];
        for (int k = 1; k < N; ++k) all = hn::Add(all, v[k]);
        return static_cast<double>(hn::GetLane(hn::SumOfLanes(D(), all)));
    }
    HWY_INLINE double largest() const {
        V all = v[0];
        for (int k = 1; k < N; ++k) all = hn::Max(all, v[k]);
        return static_cast<double>(hn::GetLane(hn::MaxOfLanes(D(), all)));
    }

    friend HWY_INLINE Pack operator+(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Add(x, y); }); }
    friend HWY_INLINE Pack operator-(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Sub(x, y); }); }
    friend HWY_INLINE Pack operator*(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Mul(x, y); }); }
    friend HWY_INLINE Pack operator/(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Div(x, y); }); }
    friend HWY_INLINE Pack operator-(Pack a) { return both(a, a, [](V x, V) HWY_ATTR { return hn::Neg(x); }); }
    friend HWY_INLINE Pack& operator+=(Pack& a, Pack b) { return a = a + b; }
    friend HWY_INLINE Pack& operator-=(Pack& a, Pack b) { return a = a - b; }
    friend HWY_INLINE Mask<T, N> operator>(Pack a, Pack b) {
        Mask<T, N> r;
        for (int k = 0; k < N; ++k) r.m[k] = hn::Gt(a.v[k], b.v[k]);
        return r;
    }
    friend HWY_INLINE Pack larger(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Max(x, y); }); }
    friend HWY_INLINE Pack smaller(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::Min(x, y); }); }
    friend HWY_INLINE Pack magnitude(Pack a) { return both(a, a, [](V x, V) HWY_ATTR { return hn::Abs(x); }); }
    friend HWY_INLINE Pack with_sign_of(Pack a, Pack b) { return both(a, b, [](V x, V y) HWY_ATTR { return hn::CopySign(x, y); }); }
    friend HWY_INLINE Pack choose(Mask<T, N> condition, Pack yes, Pack no) {
        Pack r;
        for (int k = 0; k < N; ++k) r.v[k] = hn::IfThenElse(condition.m[k], yes.v[k], no.v[k]);
        return r;
    }

private:
    template <class F>
    static HWY_INLINE Pack both(const Pack& a, const Pack& b, F&& f) {
        Pack r;
        for (int k = 0; k < N; ++k) r.v[k] = f(a.v[k], b.v[k]);
        return r;
    }
};

// Vectors of a pack of contacts: two where there are registers for them.
constexpr int vectors_of_contacts = HWY_TARGET == HWY_AVX3 ? 2 : 1;

// What lies at rows + index[0], rows + index[step], ...: `unit` numbers each, side by side.
template <int unit, int step, class D>
HWY_INLINE hn::Vec<D> load_units(D d, const hn::TFromD<D>* rows, const std::int32_t* index) {
    if constexpr (hn::MaxLanes(D()) == unit) {
        return hn::Load(d, rows + index[0]);
    } else {
        const hn::Half<D> half;
        constexpr int units_of_a_half = static_cast<int>(hn::MaxLanes(D())) / unit / 2;
        return hn::Combine(d, load_units<unit, step>(half, rows, index + units_of_a_half * step), load_units<unit, step>(half, rows, index));
    }
}

// Blocks of two doubles of two vectors a, b of this level.
#if HWY_TARGET == HWY_AVX3
template <class V>
HWY_INLINE V even_blocks(V a, V b) { return V{_mm512_shuffle_f64x2(a.raw, b.raw, 0x88)}; } // a0 a2 b0 b2
template <class V>
HWY_INLINE V odd_blocks(V a, V b) { return V{_mm512_shuffle_f64x2(a.raw, b.raw, 0xDD)}; } // a1 a3 b1 b3
template <class V>
HWY_INLINE V first_pairs_of_blocks(V a, V b) { return V{_mm512_permutex2var_pd(a.raw, _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), b.raw)}; } // a0 b0 a1 b1
template <class V>
HWY_INLINE V last_pairs_of_blocks(V a, V b) { return V{_mm512_permutex2var_pd(a.raw, _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15), b.raw)}; } // a2 b2 a3 b3
#elif HWY_TARGET == HWY_AVX2
template <class V>
HWY_INLINE V even_blocks(V a, V b) { return hn::ConcatLowerLower(hn::DFromV<V>(), b, a); } // a0 b0
template <class V>
HWY_INLINE V odd_blocks(V a, V b) { return hn::ConcatUpperUpper(hn::DFromV<V>(), b, a); } // a1 b1
template <class V>
HWY_INLINE V first_pairs_of_blocks(V a, V b) { return even_blocks(a, b); }
template <class V>
HWY_INLINE V last_pairs_of_blocks(V a, V b) { return odd_blocks(a, b); }
#else // one block to a vector: named below, never called
template <class V> V even_blocks(V, V);
template <class V> V odd_blocks(V, V);
template <class V> V first_pairs_of_blocks(V, V);
template <class V> V last_pairs_of_blocks(V, V);
#endif

// Three columns of the rows of four at rows + index[lane], for one vector of lanes. (A gather by hand: loads of rows and
// in-block transposes; the hardware's gathers are slower on the machines measured.)
template <class V>
HWY_INLINE void gather_vector(const float* rows, const std::int32_t* index, V& x, V& y, V& z) {
    const hn::ScalableTag<float> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const auto r0 = load_units<4, 4>(d, rows, index), r1 = load_units<4, 4>(d, rows, index + 1);
    const auto r2 = load_units<4, 4>(d, rows, index + 2), r3 = load_units<4, 4>(d, rows, index + 3);
    const auto xy01 = hn::InterleaveLower(d, r0, r1), xy23 = hn::InterleaveLower(d, r2, r3); // x0 x1 y0 y1 in each block
    const auto z01 = hn::InterleaveUpper(d, r0, r1), z23 = hn::InterleaveUpper(d, r2, r3);
    x = hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, xy01), hn::BitCast(wide, xy23)));
    y = hn::BitCast(d, hn::InterleaveUpper(wide, hn::BitCast(wide, xy01), hn::BitCast(wide, xy23)));
    z = hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, z01), hn::BitCast(wide, z23)));
}

template <class V>
HWY_INLINE void gather_vector(const double* rows, const std::int32_t* index, V& x, V& y, V& z) {
    const hn::ScalableTag<double> d;
    if constexpr (hn::MaxLanes(hn::ScalableTag<double>()) >= 4) {
        // Rows k and k + 2 side by side (or row k alone): blocks x_k y_k | z_k 0.
        constexpr int other = hn::MaxLanes(hn::ScalableTag<double>()) == 8 ? 4 : 2;
        const auto r0 = load_units<4, 2>(d, rows, index), r1 = load_units<4, 2>(d, rows, index + 1);
        const auto r2 = load_units<4, 2>(d, rows, index + other), r3 = load_units<4, 2>(d, rows, index + other + 1);
        const auto xz01 = hn::InterleaveLower(d, r0, r1), xz23 = hn::InterleaveLower(d, r2, r3); // x0 x1 | z0 z1 | x2 x3 | z2 z3
        const auto y01 = hn::InterleaveUpper(d, r0, r1), y23 = hn::InterleaveUpper(d, r2, r3);
        x = even_blocks(xz01, xz23);
        y = even_blocks(y01, y23);
        z = odd_blocks(xz01, xz23);
    } else {
        const auto xy0 = load_units<2, 2>(d, rows, index), xy1 = load_units<2, 2>(d, rows, index + 1);
        const auto z0 = load_units<2, 2>(d, rows + 2, index), z1 = load_units<2, 2>(d, rows + 2, index + 1);
        x = hn::InterleaveLower(d, xy0, xy1);
        y = hn::InterleaveUpper(d, xy0, xy1);
        z = hn::InterleaveLower(d, z0, z1);
    }
}

// The other way: one row {x, y, z, 0} per lane, in whatever order of lanes costs least (row_order says which).
template <class V>
HWY_INLINE void store_vector(V x, V y, V z, float* rows) {
    const hn::ScalableTag<float> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    constexpr int n = Pack<float>::lanes;
    const auto zero = hn::Zero(d);
    const auto xy0 = hn::BitCast(wide, hn::InterleaveLower(d, x, y)), xy2 = hn::BitCast(wide, hn::InterleaveUpper(d, x, y)); // x0 y0 x1 y1
    const auto z0 = hn::BitCast(wide, hn::InterleaveLower(d, z, zero)), z2 = hn::BitCast(wide, hn::InterleaveUpper(d, z, zero));
    hn::Store(hn::BitCast(d, hn::InterleaveLower(wide, xy0, z0)), d, rows);
    hn::Store(hn::BitCast(d, hn::InterleaveUpper(wide, xy0, z0)), d, rows + n);
    hn::Store(hn::BitCast(d, hn::InterleaveLower(wide, xy2, z2)), d, rows + 2 * n);
    hn::Store(hn::BitCast(d, hn::InterleaveUpper(wide, xy2, z2)), d, rows + 3 * n);
}
template <class V>
HWY_INLINE void store_vector(V x, V y, V z, double* rows) {
    const hn::ScalableTag<double> d;
    constexpr int n = Pack<double>::lanes;
    const auto zero = hn::Zero(d);
    const auto xy0 = hn::InterleaveLower(d, x, y), xy1 = hn::InterleaveUpper(d, x, y); // blocks x0 y0 | x2 y2 | ...
    const auto z0 = hn::InterleaveLower(d, z, zero), z1 = hn::InterleaveUpper(d, z, zero);
    if constexpr (n >= 4) {
        hn::Store(first_pairs_of_blocks(xy0, z0), d, rows);
        hn::Store(last_pairs_of_blocks(xy0, z0), d, rows + n);
        hn::Store(first_pairs_of_blocks(xy1, z1), d, rows + 2 * n);
        hn::Store(last_pairs_of_blocks(xy1, z1), d, rows + 3 * n);
    } else {
        hn::Store(xy0, d, rows);
        hn::Store(z0, d, rows + n);
        hn::Store(xy1, d, rows + 2 * n);
        hn::Store(z1, d, rows + 3 * n);
    }
}

// For packs of several vectors.
template <class T, int N>
HWY_INLINE void gather_rows(const T* rows, const std::int32_t* index, Pack<T, N>& x, Pack<T, N>& y, Pack<T, N>& z) {
    for (int k = 0; k < N; ++k) gather_vector(rows, index + k * Pack<T>::lanes, x.v[k], y.v[k], z.v[k]);
}
template <class T, int N>
HWY_INLINE void store_rows(const Pack<T, N>& x, const Pack<T, N>& y, const Pack<T, N>& z, T* rows) {
    for (int k = 0; k < N; ++k) store_vector(x.v[k], y.v[k], z.v[k], rows + 4 * k * Pack<T>::lanes);
}

// Where store_rows puts the row of each lane of a pack: asked of itself.
template <class T, int N>
void row_order(std::int8_t (&row_of_lane)[64]) {
    using P = Pack<T, N>;
    alignas(64) T number[P::lanes], rows[4 * P::lanes];
    for (int lane = 0; lane < P::lanes; ++lane) number[lane] = static_cast<T>(lane + 1);
    const P lanes = P::load(number);
    store_rows(lanes, P(), P(), rows);
    for (int row = 0; row < P::lanes; ++row) row_of_lane[static_cast<int>(rows[4 * row]) - 1] = static_cast<std::int8_t>(row);
}

} // namespace talik::farm::inline HWY_NAMESPACE

namespace talik::farm {
template <class T, int N>
struct ScalarOf<HWY_NAMESPACE::Pack<T, N>> { using Type = T; };
} // namespace talik::farm
