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
    using D = hn::ScalableTag<T>;
    hn::Mask<D> m;
    friend HWY_INLINE Mask operator&(Mask a, Mask b) { return {hn::And(a.m, b.m)}; }
    friend HWY_INLINE Mask operator|(Mask a, Mask b) { return {hn::Or(a.m, b.m)}; }
    friend HWY_INLINE Mask operator!(Mask a) { return {hn::Not(a.m)}; }
};

template <class T>
struct Pack {
    using D = hn::ScalableTag<T>;
    using V = hn::Vec<D>;
    static constexpr int lanes = static_cast<int>(HWY_LANES(T));

    V v;

    Pack() : v(hn::Zero(D())) {}
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
    friend HWY_INLINE Mask<T> operator<(Pack a, Pack b) { return {hn::Lt(a.v, b.v)}; }
    friend HWY_INLINE Pack larger(Pack a, Pack b) { return hn::Max(a.v, b.v); }
    friend HWY_INLINE Pack smaller(Pack a, Pack b) { return hn::Min(a.v, b.v); }
    friend HWY_INLINE Pack magnitude(Pack a) { return hn::Abs(a.v); }
    friend HWY_INLINE Pack with_sign_of(Pack a, Pack b) { return hn::CopySign(a.v, b.v); }
    friend HWY_INLINE Pack choose(Mask<T> condition, Pack yes, Pack no) { return hn::IfThenElse(condition.m, yes.v, no.v); }
};

// One block of 16 bytes from each of `Lanes(d) / rows_of_a_block` addresses, lane by lane: block b of the result comes from
// rows + index[b * step].
template <int step, class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const hn::TFromD<D>* rows, const std::int32_t* index) {
    using T = hn::TFromD<D>;
    constexpr int block = static_cast<int>(16 / sizeof(T));
    if constexpr (hn::MaxLanes(D()) == block) {
        return hn::Load(d, rows + index[0]);
    } else {
        const hn::Half<D> half;
        constexpr int half_blocks = static_cast<int>(hn::MaxLanes(D())) / block / 2;
        return hn::Combine(d, load_blocks<step>(half, rows, index + half_blocks * step), load_blocks<step>(half, rows, index));
    }
}

// Three columns of the rows of four at rows + index[lane]. (A gather by hand: loads of rows and in-block
// transposes take half of the time of the hardware's gathers on the machines measured, docs/performance.md.)
HWY_INLINE void gather_rows(const float* rows, const std::int32_t* index, Pack<float>& x, Pack<float>& y, Pack<float>& z) {
    const hn::ScalableTag<float> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const auto r0 = load_blocks<4>(d, rows, index), r1 = load_blocks<4>(d, rows, index + 1);
    const auto r2 = load_blocks<4>(d, rows, index + 2), r3 = load_blocks<4>(d, rows, index + 3);
    const auto xy01 = hn::InterleaveLower(d, r0, r1), xy23 = hn::InterleaveLower(d, r2, r3); // x0 x1 y0 y1 in each block
    const auto z01 = hn::InterleaveUpper(d, r0, r1), z23 = hn::InterleaveUpper(d, r2, r3);
    x = hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, xy01), hn::BitCast(wide, xy23)));
    y = hn::BitCast(d, hn::InterleaveUpper(wide, hn::BitCast(wide, xy01), hn::BitCast(wide, xy23)));
    z = hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, z01), hn::BitCast(wide, z23)));
}

HWY_INLINE void gather_rows(const double* rows, const std::int32_t* index, Pack<double>& x, Pack<double>& y, Pack<double>& z) {
    const hn::ScalableTag<double> d;
    const auto xy0 = load_blocks<2>(d, rows, index), xy1 = load_blocks<2>(d, rows, index + 1);
    const auto z0 = load_blocks<2>(d, rows + 2, index), z1 = load_blocks<2>(d, rows + 2, index + 1);
    x = hn::InterleaveLower(d, xy0, xy1);
    y = hn::InterleaveUpper(d, xy0, xy1);
    z = hn::InterleaveLower(d, z0, z1);
}

// The other way: one row {x, y, z, 0} per lane, contiguous. Where the rows land within the group is the layout's matter:
// floats are transposed within blocks only, so row k * blocks + b is that of lane 4 b + k (row_of_lane).
HWY_INLINE void store_rows(Pack<float> x, Pack<float> y, Pack<float> z, float* rows) {
    const hn::ScalableTag<float> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const auto zero = hn::Zero(d);
    const auto xy_lower = hn::InterleaveLower(d, x.v, y.v), xy_upper = hn::InterleaveUpper(d, x.v, y.v); // x0 y0 x1 y1 | x2 y2 x3 y3
    const auto z_lower = hn::InterleaveLower(d, z.v, zero), z_upper = hn::InterleaveUpper(d, z.v, zero);
    constexpr int n = Pack<float>::lanes;
    const auto put = [&](auto low, auto high, float* at) HWY_ATTR { hn::Store(hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, low), hn::BitCast(wide, high))), d, at); };
    const auto put_upper = [&](auto low, auto high, float* at) HWY_ATTR { hn::Store(hn::BitCast(d, hn::InterleaveUpper(wide, hn::BitCast(wide, low), hn::BitCast(wide, high))), d, at); };
    put(xy_lower, z_lower, rows);
    put_upper(xy_lower, z_lower, rows + n);
    put(xy_upper, z_upper, rows + 2 * n);
    put_upper(xy_upper, z_upper, rows + 3 * n);
}
HWY_INLINE void store_rows(Pack<double> x, Pack<double> y, Pack<double> z, double* rows) {
    const hn::ScalableTag<double> d;
    hn::StoreInterleaved4(x.v, y.v, z.v, hn::Zero(d), d, rows);
}

} // namespace talik::farm::inline HWY_NAMESPACE

namespace talik::farm {
template <class T>
struct ScalarOf<HWY_NAMESPACE::Pack<T>> { using Type = T; };
} // namespace talik::farm
