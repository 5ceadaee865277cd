#pragma once
// The kernel: a block of the grid is a block of run_block.hpp. Included by the files that instantiate it.
#include "common/team/cuda_block_team.hpp"
#include "rve-farm/block/run_block.hpp"
#include "rve-farm/block/visit_block_physics.hpp"
#include "rve-farm/cuda/cuda_kernels.hpp"

namespace talik::farm {

template <bool ledger, bool spread, class Real, class Physics>
__global__ void __launch_bounds__(32 * warps_of_a_multiprocessor<Real>(spread), 1)
    run_chunks(BlockSource source, Physics physics, ContactLaw<double> law, std::size_t shared_bytes) {
    extern __shared__ __align__(16) unsigned char shared[];
    const CudaBlockTeam team;
    run_block<ledger, spread, Real>(team, source, static_cast<int>(blockIdx.x), physics, law, reinterpret_cast<std::byte*>(shared), shared_bytes);
}

template <class Real>
cudaError_t launch_in(const BlockLaunch& launch, cudaStream_t stream) {
    cudaError_t error = cudaSuccess;
    const BlockSource source{launch.rves, launch.tasks, launch.results};
    visit_block_physics_in<Real>(launch, [&](auto ledger, auto spread, const auto& physics, Real) {
        using PhysicsOfRun = std::remove_cv_t<std::remove_reference_t<decltype(physics)>>;
        const auto kernel = run_chunks<decltype(ledger)::value, decltype(spread)::value, Real, PhysicsOfRun>;
        // More than 48 KiB have to be asked for, for each kernel and device.
        error = cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(launch.shared_bytes));
        if (error != cudaSuccess) return;
        // What a multiprocessor has of it, not of the first cache: as many blocks as it can hold.
        error = cudaFuncSetAttribute(kernel, cudaFuncAttributePreferredSharedMemoryCarveout, cudaSharedmemCarveoutMaxShared);
        if (error != cudaSuccess) return;
        kernel<<<static_cast<unsigned>(launch.blocks), static_cast<unsigned>(launch.threads), launch.shared_bytes, stream>>>(
            source, physics, contact_law_of(*launch.parameters), launch.shared_bytes);
        error = cudaGetLastError();
    });
    return error;
}

} // namespace talik::farm
