"""The catalogue: which kinds of fault there are, and which tasks they may meet."""

from __future__ import annotations

from burnish.campaign import commanded, measured, physical
from burnish.campaign.fault import Kind

ANYWHERE: tuple[Kind, ...] = (
    measured.garbage_reading,
    measured.garbage_sample,
    measured.stuck_reading,
    measured.stuck_joint,
    measured.encoder_jump,
    measured.encoder_offset,
    measured.speed_offset,
    measured.torque_offset,
    measured.wrench_offset,
    measured.degrees_reading,
    measured.nothing_new,
    measured.lost_samples,
    measured.delayed_reading,
    measured.wrong_clock,
    commanded.not_finite,
    commanded.wrong_length,
    commanded.exception,
    commanded.too_strong,
    commanded.runaway,
    commanded.square_wave,
    commanded.stuck_torque,
    commanded.no_weight,
    measured.hang,
    physical.late_commands,
    physical.jitter,
    physical.wrong_model,
    physical.friction,
    commanded.target_jump,
)
"""Kinds of fault that may meet every task."""
LOADED: tuple[Kind, ...] = (physical.payload, physical.missing_payload)
"""Those of tasks that touch nothing."""
OF_JOINTS: tuple[Kind, ...] = (commanded.target_in_degrees, commanded.target_beyond_limit)
"""Those of tasks of the joints."""
OF_TOOL: tuple[Kind, ...] = (commanded.target_out_of_reach,)
"""Those of the operator's tool."""
PRESSING: tuple[Kind, ...] = (physical.sudden_contact, physical.contact_lost)
"""Those of a tool that presses."""
KINDS = (*ANYWHERE, *LOADED, *OF_JOINTS, *OF_TOOL, *PRESSING)
"""All kinds of fault."""
