"""The directions, printed sides and frames of the papers' claims, typed from their sentences and tables."""

# The end of a word of the selection whose quantity is the higher one: of a table's cells the larger number, whether it
# is the better one or not. Where both are the same in print, "=".
HIGHER = {
    line.split()[0]: line.split()[1]
    for line in """
    nsrr-1 model.upsample=zero
    nsrr-2 model.warp_at=target
    nsrr-3 model.warp_at=target
    nsrr-4 model.upsample=zero
    nsrr-5 model.reweight=learned
    nsrr-6 model.extract=learned
    nsrr-7 model.extract=learned
    nsrr-8 model.reweight=learned
    nsrr-9 model.previous=4
    nsrr-10 model.previous=4
    nsrr-11 task.scale=2
    nsrr-12 model=nsrr
    nsrr-13 model=nsrr
    nsrr-14 model.colour_space=ycbcr
    nsrr-15 model=nsrr
    nsrr-16 model=nsrr
    nsrr-17 model=nsrr
    nsrr-18 model=nsrr
    nsrr-19 model=nsrr
    nsrr-20 model=edsr
    nsrr-21 model=nsrr
    nsrr-22 model=nsrr_fast
    nsrr-23 model=nsrr
    nsrr-24 model.previous=4
    nsrr-25 model.previous=4
    nsrr-26 model=none
    nsrr-27 model=vespcn_plus
    nsrr-28 test.scenes=same
    nsrr-29 test.scenes=same
    nsrr-30 test.scenes=subset
    nsrr-31 model=nsrr
    nsrr-32 part=total
    nsrd-1 model.demodulate=log_lighting
    nsrd-2 model.demodulate=lighting|log_lighting
    nsrd-3 model=nsrd
    nsrd-4 model.recur=convlstm
    nsrd-5 model.recur=convlstm
    nsrd-6 model.recur=convlstm
    nsrd-7 loss.weights.masked_temporal=0
    nsrd-8 loss.weights.masked_temporal=1
    nsrd-9 model.motion_mask=dual
    nsrd-10 model=nsrd
    nsrd-11 model=nsrr
    nsrd-12 model=nsrd
    nsrd-13 model=nsrd
    nsrd-14 model=nsrr
    nsrd-15 task.scale=2
    nsrd-16 model=nsrd
    nsrd-17 model=nsrd
    nsrd-18 model.demodulate=lighting
    nsrd-19 model=nsrd
    nsrd-20 model=nsrd
    nsrd-21 model=none
    nsrd-22 model=nsrr
    nsrd-23 model.recur=none
    nsrd-24 model.recur=convlstm
    nsrd-25 model.demodulate=lighting|log_lighting
    nsrd-26 model=basicvsr_unidirectional
    nsrd-27 model=basicvsr_unidirectional
    nsrd-28 model=basicvsr_unidirectional
    nsrd-29 model=nsrd
    nsrd-30 model=nsrd
    nsrd-31 part=render.high+render.g_buffers+total
    enss-1 model=enss_s
    enss-2 model=enss_l
    enss-3 model=enss_l
    enss-4 model=enss_l
    enss-5 model=enss_l
    enss-6 model=nsrr
    enss-7 task.scale=2
    enss-8 model=enss_l
    enss-9 model.motion_grid=bilinear
    enss-10 model.motion_grid=block
    enss-11 model.history=unblended
    enss-12 =
    enss-13 task.jitter=halton16|thesis
    enss-14 task.jitter=halton16|thesis
    enss-15 model.history=blended
    enss-16 model.history=none
    enss-17 model.kernel_prediction=both
    enss-18 model.kernel_prediction=last
    enss-19 model.flow=motion_vectors
    enss-20 model.flow=motion_vectors
    enss-21 model.flow=none
    enss-22 model.flow=motion_vectors
    enss-23 data.camera=walk
    enss-24 loss=l1
    enss-25 loss=l1
    enss-26 model=nsrr
    enss-27 model=enss_l
    enss-28 model=nsrr
    enss-29 model=enss_l
    enss-30 task.jitter=halton16|thesis
    enss-31 model.history=blended
    enss-32 loss=nsrr
    enss-33 model.kernel_prediction=both
    enss-35 model=nsrr
    enss-34 data.scenes=airstrip,arena,atrium,bar,foundry,louvres,market,sundial,turntable
    dlctus-1 model=dlctus
    dlctus-2 model=dlctus
    dlctus-3 model=nsrr
    dlctus-4 model=dlctus
    dlctus-5 model=tus_thesis
    dlctus-6 model.reproject=bicubic9
    dlctus-7 model.reproject=bicubic9
    dlctus-8 model.reproject=bicubic5
    dlctus-9 model.dilate=none
    dlctus-10 model.dilate=closest
    dlctus-11 model.accumulate=buffer
    dlctus-12 model.accumulate=buffer
    dlctus-13 model.accumulate=none
    dlctus-14 loss=l1
    dlctus-15 loss.theta=0.1
    dlctus-16 loss=l1
    dlctus-17 loss=l1
    dlctus-18 loss=l1
    dlctus-19 loss=l1
    dlctus-20 model=jau
    dlctus-21 task.mip_bias=matched
    dlctus-22 model=nsrr
    dlctus-23 model=nsrr
    dlctus-24 model=dlctus
    dlctus-25 model=nsrr
    dlctus-26 model=dlctus
    dlctus-27 model=dlctus
    dlctus-28 model.accumulate=none
    dlctus-29 model.accumulate=buffer
    dlctus-30 model.accumulate=buffer
    dlctus-31 =
    dlctus-32 =
    dlctus-33 model=nsrr
    dlctus-34 model=dlctus
    dlctus-35 model=dlctus
    dlctus-36 loss.theta=0.9
    dlctus-37 loss.theta=0.1
    dlctus-38 budget.epochs=18
    dlctus-39 task.scale=2
    dlctus-40 model=jau
    dlctus-41 model=bicubic
    dlctus-42 backend=eager
    dlctus-43 backend=thesis_1
    dlctus-44 part=total
    """.strip().splitlines()
}
# Both sides of factors and percentages as they are printed, a and b; frames from 0.
PRINTED = {
    "nsrr-25": (24.42, 21.36),
    "nsrr-26": (44.08, 140.6),
    "nsrr-32": (17.2, 24.4),
    "nsrd-21": (29.3, 89.6),
    "nsrd-27": (12.41, 75.21),
    "nsrd-28": (1.61e6, 4.87e6),
    "nsrd-31": (0.84, 14.03),
    "enss-6": (3.52, 13.93),
    "enss-11": (0.54, 1.10),
    "enss-26": (1.62, 13.80),
    "enss-30": (0.03, 0.54),
    "dlctus-22": (2.15, 24.4),
    "dlctus-39": (2146, 2151),
    "dlctus-42": (2638, 2930),
    "dlctus-43": (2146, 2638),
    "dlctus-44": (1.476, 2.146),
}
RANGES = {"dlctus-23": [4, 6], "dlctus-24": [10, 59], "dlctus-25": [4, 6], "dlctus-29": [12, 59]}
