"""The version of the package, as it is installed."""

from importlib.metadata import PackageNotFoundError, version


def product_version() -> str | None:
    """Version; None of a checkout that is not installed."""
    try:
        return version("truenorth")
    except PackageNotFoundError:
        return None
