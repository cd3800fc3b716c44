# SPDX-License-Identifier: BSD-3-Clause
"""Reads server-manager XML as ParaView does: a proxy has the elements of its base proxy before its own. Needs no ParaView."""

import os
import xml.etree.ElementTree as ElementTree

#: The group of proxies that are bases of others and can not be created.
BASES = "surface_synthesis_bases"


def proxy_of(path):
    """The proxy in an XML file with the properties of its base, which is in the file of its name beside it."""
    proxy = ElementTree.parse(path).getroot().find("ProxyGroup/SourceProxy")
    base = proxy.get("base_proxyname")
    if base is not None:
        assert proxy.get("base_proxygroup") == BASES, path
        inherited = proxy_of(os.path.join(os.path.dirname(path), base + ".xml"))
        assert is_base(os.path.join(os.path.dirname(path), base + ".xml")) and inherited.get("name") == base
        own, overridden = set(), set()
        for element in proxy:
            if element.tag.endswith("Property"):
                (overridden if element.get("override") == "1" else own).add(element.get("name"))
        shared = [element for element in inherited if element.tag.endswith("Property")]
        unknown = overridden - {element.get("name") for element in shared}
        assert not unknown, f"{path} overrides {sorted(unknown)}, which {base}.xml has not"
        shared = [element for element in shared if element.get("name") not in overridden]
        repeated = own & {element.get("name") for element in shared}
        assert not repeated, f"{path} repeats {sorted(repeated)} of {base}.xml"
        for place, element in enumerate(shared):
            proxy.insert(place, element)
    return proxy


def is_former(element):
    """True for a property under its former name, which no panel shows."""
    return element.get("panel_visibility") == "never"


def is_base(path):
    """True for a file whose proxy is only a base of others."""
    return ElementTree.parse(path).getroot().find("ProxyGroup").get("name") == BASES
