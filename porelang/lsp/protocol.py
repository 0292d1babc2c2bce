"""What is said to a client whose request cannot be read: an answer, so that it does not wait for one."""

from __future__ import annotations

from typing import Any

from lsprotocol.types import ResponseError
from pygls.exceptions import JsonRpcException
from pygls.protocol import LanguageServerProtocol
from pygls.protocol.json_rpc import JsonRPCNotification


class Protocol(LanguageServerProtocol):
    """The protocol, by which every request has an answer: pygls reports what it cannot read, and leaves it at that."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """A message as an object; of a request that is none, a notification that nobody heeds."""
        try:
            return super().structure_message(data)
        except JsonRpcException as error:
            if "id" not in data or "method" not in data:
                raise
            why = f"the parameters of {data['method']} are not those of the protocol"
            self._send_response(data["id"], error=ResponseError(error.CODE, why))
            return JsonRPCNotification("$/refused", self.VERSION, None)
