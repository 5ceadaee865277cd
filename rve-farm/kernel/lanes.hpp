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

template <class T>
struct Mask {
    hn::Mask<hn::ScalableTag<T>> m;
    friend HWY_INLINE Mask operator&(Mask a, Mask b) { return {hn::And(a.m, b.m)}; }
    friend HWY_INLINE Mask operator|(Mask a, Mask b) { return {hn::Or(a.m, b.m)}; }
    friend HWY_INLINE Mask operator!(Mask a) { return {hn::Not(a.m)}; }
};

// a brought back to at most `limit` >= 0 either way; AVX-512 does it in one.
template <class V>
HWY_INLINE V brought_within(V limit, V a) {
#if HWY_TARGET == HWY_AVX3
    constexpr int smaller_magnitude_with_sign_of_first = 2;
    if constexpr (sizeof(hn::TFromV<V>) == 4) return V{_mm512_range_ps(a.raw, limit.raw, smaller_magnitude_with_sign_of_first)};
    else return V{_mm512_range_pd(a.raw, limit.raw, smaller_magnitude_with_sign_of_first)};
#else
    return hn::Min(hn::Max(a, hn::Neg(limit)), limit);
#endif
}

// A vector as a number.
template <class T>
struct Pack {
    using D = hn::ScalableTag<T>;
    using V = hn::Vec<D>;
    static constexpr int lanes = static_cast<int>(HWY_LANES(T));

    V v = hn::Zero(D());

    HWY_INLINE Pack() = default;
    HWY_INLINE Pack(V vector) : v(vector) {}
    HWY_INLINE Pack(double number) : v(hn::Set(D(), static_cast<T>(number))) {} // the same in every lane
    static HWY_INLINE Pack load(const T* aligned) { return hn::Load(D(), aligned); }
    HWY_INLINE void store(T* aligned) const { hn::Store(v, D(), aligned); }
    HWY_INLINE double sum() const { return static_cast<double>(hn::GetLane(hn::SumOfLanes(D(), v))); }
    HWY_INLINE double largest() const { return static_cast<double>(hn::GetLane(hn::MaxOfLanes(D(), v))); }

    friend HWY_INLINE Pack operator+(Pack a, Pack b) { return hn::Add(a.v, b.v); }
    friend HWY_INLINE Pack operator-(Pack a, Pack b) { return hn::Sub(a.v, b.v); }
    friend HWY_INLINE Pack operator*(Pack a, Pack b) { return hn::Mul(a.v, b.v); }
    friend HWY_INLINE Pack operator/(Pack a, Pack b) { return hn::Div(a.v, b.v); }
    friend HWY_INLINE Pack operator-(Pack a) { return hn::Neg(a.v); }
    friend HWY_INLINE Pack& operator+=(Pack& a, Pack b) { return a = a + b; }
    friend HWY_INLINE Pack& operator-=(Pack& a, Pack b) { return a = a - b; }
    friend HWY_INLINE Mask<T> operator>(Pack a, Pack b) { return {hn::Gt(a.v, b.v)}; }
    friend HWY_INLINE Pack larger(Pack a, Pack b) { return hn::Max(a.v, b.v); }
    friend HWY_INLINE Pack smaller(Pack a, Pack b) { return hn::Min(a.v, b.v); }
    friend HWY_INLINE Pack within(Pack limit, Pack a) { return brought_within(limit.v, a.v); }
    friend HWY_INLINE Pack magnitude(Pack a) { return hn::Abs(a.v); }
    friend HWY_INLINE Pack root(Pack a) { return hn::Sqrt(a.v); }
    friend HWY_INLINE Pack with_sign_of(Pack a, Pack b) { return hn::CopySign(a.v, b.v); }
    friend HWY_INLINE Pack choose(Mask<T> condition, Pack yes, Pack no) { return hn::IfThenElse(condition.m, yes.v, no.v); }
};

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

// The rows of four at rows + index[lane], for one vector of lanes: fetched as rows, added as rows, transposed at the end. (A
// gather by hand: loads of rows and in-block transposes; the hardware's gathers are slower on the machines measured.)
template <class T>
struct RowsOfLanes;

template <>
struct RowsOfLanes<float> {
    using D = hn::ScalableTag<float>;
    hn::Vec<D> r[4]; // each block of r[p]: the row of its p-th lane

    HWY_INLINE RowsOfLanes(const float* rows, const std::int32_t* index) { for (int p = 0; p < 4; ++p) r[p] = load_units<4, 4>(D(), rows, index + p); }
    template <class V>
    HWY_INLINE void transpose(V& x, V& y, V& z, V& w) const {
        const D d;
        const hn::RepartitionToWide<D> wide;
        const auto xy01 = hn::BitCast(wide, hn::InterleaveLower(d, r[0], r[1])), xy23 = hn::BitCast(wide, hn::InterleaveLower(d, r[2], r[3])); // x0 x1 y0 y1
        const auto zw01 = hn::BitCast(wide, hn::InterleaveUpper(d, r[0], r[1])), zw23 = hn::BitCast(wide, hn::InterleaveUpper(d, r[2], r[3]));
        x = hn::BitCast(d, hn::InterleaveLower(wide, xy01, xy23));
        y = hn::BitCast(d, hn::InterleaveUpper(wide, xy01, xy23));
        z = hn::BitCast(d, hn::InterleaveLower(wide, zw01, zw23));
        w = hn::BitCast(d, hn::InterleaveUpper(wide, zw01, zw23));
    }
};

template <>
struct RowsOfLanes<double> {
    using D = hn::ScalableTag<double>;
    static constexpr int lanes = static_cast<int>(HWY_LANES(double));
    hn::Vec<D> r[4]; // rows k and k + 2 side by side (or row k alone): blocks x_k y_k | z_k w_k; with two lanes x0 y0, x1 y1, z0 w0, z1 w1

    HWY_INLINE RowsOfLanes(const double* rows, const std::int32_t* index) {
        const D d;
        if constexpr (lanes >= 4) {
            constexpr int other = lanes == 8 ? 4 : 2;
            r[0] = load_units<4, 2>(d, rows, index), r[1] = load_units<4, 2>(d, rows, index + 1);
            r[2] = load_units<4, 2>(d, rows, index + other), r[3] = load_units<4, 2>(d, rows, index + other + 1);
        } else {
            r[0] = load_units<2, 2>(d, rows, index), r[1] = load_units<2, 2>(d, rows, index + 1);
            r[2] = load_units<2, 2>(d, rows + 2, index), r[3] = load_units<2, 2>(d, rows + 2, index + 1);
        }
    }
    template <class V>
    HWY_INLINE void transpose(V& x, V& y, V& z, V& w) const {
        const D d;
        const auto xz01 = hn::InterleaveLower(d, r[0], r[1]), xz23 = hn::InterleaveLower(d, r[2], r[3]); // x0 x1 | z0 z1 | x2 x3 | z2 z3
        const auto yw01 = hn::InterleaveUpper(d, r[0], r[1]), yw23 = hn::InterleaveUpper(d, r[2], r[3]);
        if constexpr (lanes >= 4) {
            x = even_blocks(xz01, xz23);
            y = even_blocks(yw01, yw23);
            z = odd_blocks(xz01, xz23);
            w = odd_blocks(yw01, yw23);
        } else {
            x = xz01, y = yw01, z = xz23, w = yw23;
        }
    }
};

template <class T>
HWY_INLINE RowsOfLanes<T>& operator+=(RowsOfLanes<T>& a, const RowsOfLanes<T>& b) {
    for (int p = 0; p < 4; ++p) a.r[p] = hn::Add(a.r[p], b.r[p]);
    return a;
}

// The other way: one row {x, y, z, w} per lane, in whatever order of lanes costs least (row_order says which).
template <class V>
HWY_INLINE void store_vector(V x, V y, V z, V w, float* rows) {
    const hn::ScalableTag<float> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    constexpr int n = Pack<float>::lanes;
    const auto xy0 = hn::BitCast(wide, hn::InterleaveLower(d, x, y)), xy2 = hn::BitCast(wide, hn::InterleaveUpper(d, x, y)); // x0 y0 x1 y1
    const auto zw0 = hn::BitCast(wide, hn::InterleaveLower(d, z, w)), zw2 = hn::BitCast(wide, hn::InterleaveUpper(d, z, w));
    hn::Store(hn::BitCast(d, hn::InterleaveLower(wide, xy0, zw0)), d, rows);
    hn::Store(hn::BitCast(d, hn::InterleaveUpper(wide, xy0, zw0)), d, rows + n);
    hn::Store(hn::BitCast(d, hn::InterleaveLower(wide, xy2, zw2)), d, rows + 2 * n);
    hn::Store(hn::BitCast(d, hn::InterleaveUpper(wide, xy2, zw2)), d, rows + 3 * n);
}
template <class V>
HWY_INLINE void store_vector(V x, V y, V z, V w, double* rows) {
    const hn::ScalableTag<double> d;
    constexpr int n = Pack<double>::lanes;
    const auto xy0 = hn::InterleaveLower(d, x, y), xy1 = hn::InterleaveUpper(d, x, y); // blocks x0 y0 | x2 y2 | ...
    const auto zw0 = hn::InterleaveLower(d, z, w), zw1 = hn::InterleaveUpper(d, z, w);
    if constexpr (n >= 4) {
        hn::Store(first_pairs_of_blocks(xy0, zw0), d, rows);
        hn::Store(last_pairs_of_blocks(xy0, zw0), d, rows + n);
        hn::Store(first_pairs_of_blocks(xy1, zw1), d, rows + 2 * n);
        hn::Store(last_pairs_of_blocks(xy1, zw1), d, rows + 3 * n);
    } else {
        hn::Store(xy0, d, rows);
        hn::Store(zw0, d, rows + n);
        hn::Store(xy1, d, rows + 2 * n);
        hn::Store(zw1, d, rows + 3 * n);
    }
}

template <class T>
HWY_INLINE void gather_rows(const T* rows, const std::int32_t* index, Pack<T>& x, Pack<T>& y, Pack<T>& z, Pack<T>& w) {
    RowsOfLanes<T>(rows, index).transpose(x.v, y.v, z.v, w.v);
}
template <class T>
HWY_INLINE void store_rows(Pack<T> x, Pack<T> y, Pack<T> z, Pack<T> w, T* rows) { store_vector(x.v, y.v, z.v, w.v, rows); }

// Where store_rows puts the row of each lane of a pack: asked of itself.
template <class T>
void row_order(std::int8_t (&row_of_lane)[64]) {
    using P = Pack<T>;
    alignas(64) T number[P::lanes], rows[4 * P::lanes];
    for (int lane = 0; lane < P::lanes; ++lane) number[lane] = static_cast<T>(lane + 1);
    store_rows(P::load(number), P(), P(), P(), rows);
    for (int row = 0; row < P::lanes; ++row) row_of_lane[static_cast<int>(rows[4 * row]) - 1] = static_cast<std::int8_t>(row);
}

} // namespace talik::farm::inline HWY_NAMESPACE

namespace talik::farm {
template <class T>
struct ScalarOf<HWY_NAMESPACE::Pack<T>> { using Type = T; };
} // namespace talik::farm
