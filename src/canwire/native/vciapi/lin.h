// LIN connectors.
#pragma once

#include "line.h"

class LinControl : public Control<ILinControl, IID_ILinControl, LININITLINE, LINLINESTATUS> {
public:
    using Control::Control;
    HRESULT WriteMessage(BOOL send, PLINMSG message) override;
};

class LinMonitor : public Queues<ILinMonitor, IID_ILinMonitor, LINMONITORSTATUS> {
public:
    using Queues::Queues;
    HRESULT Initialize(UINT16 receive) override;
};

class LinSocket : public Socket<ILinSocket, IID_ILinSocket, LINCAPABILITIES, LINLINESTATUS> {
public:
    using Socket::Socket;
    HRESULT CreateMonitor(BOOL exclusive, ILinMonitor **into) override;
};
