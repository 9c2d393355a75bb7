"""Encoders as files: weights, configuration and nothing else that matters."""

from __future__ import annotations

import importlib
import json
import os
from pathlib import Path
from types import ModuleType

import numpy as np

from gcm_learn.errors import EncoderError, MissingExtraError
from gcm_learn.recall.encoder_config import config_from_json, config_to_json
from gcm_learn.recall.towers import Encoder
from gcm_learn.storage import write_whole

WEIGHTS, CONFIG = "encoder.safetensors", "config.json"


def save_encoder(encoder: Encoder, folder: str | os.PathLike[str]) -> None:
    """Write an encoder's weights and configuration into a folder."""
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    save = _safetensors().save
    arrays = {name: np.ascontiguousarray(a) for name, a in encoder.arrays.items()}
    write_whole(place / WEIGHTS, save(arrays, {"key": encoder.key}), durable=True)
    text = json.dumps(config_to_json(encoder.config), indent=1) + "\n"
    write_whole(place / CONFIG, text, durable=True)


def load_encoder(folder: str | os.PathLike[str]) -> Encoder:
    """Read an encoder.

    Raises
    ------
    EncoderError
        In one line: there is none, or it is damaged.
    """
    place = Path(folder)
    load = _safetensors().load
    try:
        config = config_from_json(json.loads((place / CONFIG).read_text("utf-8")))
        arrays = load((place / WEIGHTS).read_bytes())
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise EncoderError(f"{place}: no encoder there ({missing} is missing)") from None
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise EncoderError(f"{place}: not an encoder ({error})") from None
    except Exception as error:  # safetensors raises errors of its own
        raise EncoderError(f"{place / WEIGHTS}: damaged ({error})") from None
    return Encoder(config, arrays)


def _safetensors() -> ModuleType:
    """The numpy side of safetensors."""
    try:
        return importlib.import_module("safetensors.numpy")
    except ImportError:
        raise MissingExtraError("an encoder", "safetensors", "learn") from None
