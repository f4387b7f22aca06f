"""A certificate for one cluster, so that nobody else on a shared machine can talk to it."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from distributed import Security

_NAME = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "irg-internal")])
_LASTS = timedelta(days=365)


def private_security() -> Security:
    """Encryption with a key of its own, which is kept in memory and known to this cluster alone.

    `Security.temporary` does the same with an RSA key, which takes 0.1 s to make.
    """
    key = ec.generate_private_key(ec.SECP256R1())
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(_NAME)
        .issuer_name(_NAME)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + _LASTS)
        .sign(key, hashes.SHA256())
        .public_bytes(serialization.Encoding.PEM)
        .decode()
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    ).decode()
    return Security(
        require_encryption=True,
        tls_ca_file=certificate,
        **{
            f"tls_{role}_{part}": content
            for role in ("client", "scheduler", "worker")
            for part, content in (("key", secret), ("cert", certificate))
        },
    )
