"""What is said to a client whose request cannot be read: an answer, so that it does not wait for one."""

from __future__ import annotations

from typing import Any

from lsprotocol.types import INITIALIZE, ResponseError
from pygls.exceptions import JsonRpcException, JsonRpcInvalidRequest
from pygls.protocol import LanguageServerProtocol
from pygls.protocol.json_rpc import JsonRPCNotification


class Protocol(LanguageServerProtocol):
    """The protocol, by which every request has an answer: pygls reports what it cannot read, and leaves it at that."""

    _begun = False

    def handle_message(self, message: Any) -> None:
        """Do what a message asks for, if it is one, and may be asked for now."""
        method = getattr(message, "method", "")
        number = getattr(message, "id", None)
        if not hasattr(message, "jsonrpc"):
            self._refuse(None, "this is no message of the protocol: `jsonrpc` is missing")
        elif method and number is not None and self._shutdown:
            self._refuse(number, "the server has shut down: it waits for `exit`")
        elif method == INITIALIZE and self._begun:
            self._refuse(number, "the server was initialized before")
        else:
            self._begun = self._begun or method == INITIALIZE
            super().handle_message(message)

    def _refuse(self, number: Any, why: str) -> None:
        self._send_response(number, error=ResponseError(JsonRpcInvalidRequest.CODE, why))

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
