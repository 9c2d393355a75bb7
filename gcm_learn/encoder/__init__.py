"""Encoders: situations and memories in one space, where near means that the catch transfers.

`looks` says what a situation looks like at t = 0, `ways` and `pictures` what a memory looks like;
`towers` embeds them with arrays alone, `networks`, `losses` and `training` make those arrays, in
torch. Labels come from above: `lesson` is the form in which they are handed down.
"""

from gcm_learn.encoder.config import EncoderConfig
from gcm_learn.encoder.files import load_encoder, save_encoder
from gcm_learn.encoder.towers import Encoder

__all__ = ["Encoder", "EncoderConfig", "load_encoder", "save_encoder"]
