#pragma once
// The thread block of a GPU as a team (block_team.hpp). Included by .cu files only.
#include "common/team/block_team.hpp"

namespace talik {

class CudaBlockTeam {
public:
    TALIK_BLOCK int threads() const { return static_cast<int>(blockDim.x); }

    template <class T>
    class Privates {
    public:
        TALIK_BLOCK explicit Privates(const CudaBlockTeam&) {}
        TALIK_BLOCK T& operator()(int) { return value_; }

    private:
        T value_{};
    };

    template <class Body>
    TALIK_BLOCK void phase(Body&& body) const {
        body(static_cast<int>(threadIdx.x));
        __syncthreads();
    }
};

} // namespace talik
