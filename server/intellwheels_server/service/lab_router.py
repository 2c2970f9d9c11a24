"""The configuration of a lab's router: who may connect, what each identity may do, and how long its messages may be."""

from __future__ import annotations

import datetime
from typing import Any

from intellwheels_schemas.access_rules import Rule, rules_for
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.lab_rules import has_expired
from intellwheels_schemas.messages import Identity, Lab
from intellwheels_schemas.rights import rights_key
from intellwheels_schemas.traffic_limits import size_limits
from intellwheels_server.service.lab_files import LabFiles, read_lab, read_users, router_until


def checked_settings(files: LabFiles, today: datetime.date, *, printed: bool) -> dict[str, Any]:
    """Return the settings of the router of a lab, after checks of its files.

    Args:
        files: The files of the lab.
        today: The day in UTC.
        printed: Whether the settings are for print only, so that passwords may be lacking.

    Raises:
        WireError: A file is missing or wrong, or the router's certificate has expired; the text says what to do.
    """
    lab = read_lab(files.lab)
    known = {} if printed else read_users(files.users)
    lacking = [one.name for one in lab.identity if not has_expired(one, today) and one.name not in known]
    if lacking and not printed:
        text = f"{files.users}: expected a password for {', '.join(lacking)}, got none; run iw-lab keys {files.lab}"
        raise WireError("value", text, str(files.users))
    until = router_until(files)
    where = str(files.router)
    if until is None and any(identity.certificate for identity in lab.identity):
        raise WireError("value", f"{where}: expected the router's certificate, got none; run iw-lab keys", where)
    if until is not None and until < today:
        raise WireError("value", f"{where}: the router's certificate expired after {until}; run iw-lab keys", where)
    return lab_settings(lab, files, today)


def lab_settings(lab: Lab, files: LabFiles, today: datetime.date) -> dict[str, Any]:
    """Return the settings of a router that allows what a lab lists and denies everything else.

    Args:
        lab: The document.
        files: The files of the lab; the settings name those with secrets and do not contain them.
        today: The day in UTC; an identity whose last day is over may nothing.
    """
    identities = [one for one in lab.identity if not has_expired(one, today)]
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    for identity in identities:
        rights = (rights_key(identity.name),)
        own = [Rule(("query",), "ingress", rights), Rule(("reply",), "egress", rights)]
        own += [rule for may in identity.may for rule in rules_for(may)]
        names = [f"{identity.name}/{number}" for number in range(len(own))]
        for name, rule in zip(names, own, strict=True):
            rules.append({
                "id": name, "permission": "allow", "flows": [rule.flow], "messages": list(rule.messages),
                "key_exprs": list(rule.keys),
            })  # fmt: skip
        policies.append({"rules": names, "subjects": [identity.name]})
    return {
        "access_control": {
            "enabled": True,
            "default_permission": "deny",
            "rules": rules,
            "subjects": [_subject(identity) for identity in identities],
            "policies": policies,
        },
        "low_pass_filter": size_limits(),
        "transport/auth/usrpwd": {"dictionary_file": str(files.users)},
        "adminspace/enabled": False,
        **_tls(lab, files),
    }


def _subject(identity: Identity) -> dict[str, Any]:
    # Zenoh compares both: a certificate alone, or the password of another, is not enough.
    names = [identity.name]
    more = {"cert_common_names": names} if identity.certificate else {}
    return {"id": identity.name, "usernames": names, **more}


def _tls(lab: Lab, files: LabFiles) -> dict[str, Any]:
    if not files.router.exists():
        return {}
    return {
        "transport/link/tls": {
            "root_ca_certificate": str(files.authority),
            "listen_certificate": str(files.router),
            "listen_private_key": str(files.router_key),
            "enable_mtls": any(identity.certificate for identity in lab.identity),
            "close_link_on_expiration": True,
        }
    }
